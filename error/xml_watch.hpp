// What both XML readers share: Expat's faults in our words, and references to text that Expat does not read.
// Expat expands entities that the file itself defines, and drops all others without a word.
#pragma once

#include <expat.h>
#include <fmt/core.h>

#include <new>
#include <set>
#include <string>
#include <string_view>

namespace borelli {

/// Refuses references to entities whose text Expat does not insert. Expat gets it as its user data. Readers
/// derive their handlers of elements from this class.
class XmlWatch {
 public:
  /// `text`: the document, in memory while it is parsed.
  XmlWatch(XML_Parser parser, std::string_view text) : parser_(parser), text_(text) {
    XML_SetUserData(parser, this);
    XML_SetDoctypeDeclHandler(parser, &XmlWatch::doctype, nullptr);
    XML_SetEntityDeclHandler(parser, &XmlWatch::declaration);
    XML_SetSkippedEntityHandler(parser, &XmlWatch::skipped);
    XML_SetExternalEntityRefHandler(parser, &XmlWatch::external);
  }

  /// Checks the attributes of the element that begins. Call it at the start of each element: Expat reports
  /// the entities that it drops from text, but not those from attributes.
  void check_attributes() {
    if (!declared_elsewhere_) return;
    const auto begin = std::size_t(XML_GetCurrentByteIndex(parser_));
    const std::string_view tag = text_.substr(begin, std::size_t(XML_GetCurrentByteCount(parser_)));
    for (std::size_t at = 0; (at = tag.find('&', at)) != tag.npos; ++at) {
      const std::string name(tag.substr(at + 1, tag.find(';', at) - at - 1));
      if (!name.starts_with('#') && !known_.contains(name)) refuse_entity(name);
    }
  }

  /// Stops the parser with this sentence.
  void refuse(std::string sentence) {
    if (refusal_.empty()) refusal_ = std::move(sentence);
    XML_StopParser(parser_, XML_FALSE);
  }

  /// Why the parser stopped: a sentence that follows the place. Throws std::bad_alloc if memory ran out.
  std::string why_stopped() const;

  XML_Parser parser() const { return parser_; }

 private:
  static XmlWatch& of(void* self) { return *static_cast<XmlWatch*>(self); }
  static void doctype(void* self, const XML_Char*, const XML_Char* file, const XML_Char*, int) {
    if (file) of(self).declared_elsewhere_ = true;
  }
  static void declaration(void* self, const XML_Char* name, int parameter, const XML_Char* value, int,
                          const XML_Char*, const XML_Char*, const XML_Char*, const XML_Char*) {
    if (parameter) of(self).declared_elsewhere_ = true;
    if (value && !parameter) of(self).known_.insert(name);
  }
  static void skipped(void* self, const XML_Char* name, int parameter) {
    if (!parameter) of(self).refuse_entity(name);
  }
  static int external(XML_Parser parser, const XML_Char*, const XML_Char*, const XML_Char* file,
                      const XML_Char*) {
    of(XML_GetUserData(parser))
        .refuse(fmt::format(
            "takes text from the file '{}' by an entity, which is not read; put the text in its place",
            file ? file : ""));
    return XML_STATUS_ERROR;
  }

  void refuse_entity(const std::string& name) {
    refuse(fmt::format("uses the entity '&{};', which the file does not define; put its text in its place",
                       name));
  }

  XML_Parser parser_;
  std::string_view text_;
  std::string refusal_;
  std::set<std::string> known_{"lt", "gt", "amp", "quot", "apos"};  // entities whose text Expat puts in
  bool declared_elsewhere_ = false;  // a file that is not read may define entities
};

/// What is wrong with a document, by Expat's error code; it ends a sentence.
inline const char* in_words(XML_Error fault) {
  switch (fault) {
    case XML_ERROR_NO_ELEMENTS:
      return "the file ends before its root element does";
    case XML_ERROR_INVALID_TOKEN:
      return "a character stands where XML does not allow it";
    case XML_ERROR_UNCLOSED_TOKEN:
    case XML_ERROR_PARTIAL_CHAR:
    case XML_ERROR_UNCLOSED_CDATA_SECTION:
      return "the file ends within a tag, a text or a comment";
    case XML_ERROR_TAG_MISMATCH:
      return "an end tag has another name than the element that it closes";
    case XML_ERROR_DUPLICATE_ATTRIBUTE:
      return "an element has two attributes of one name";
    case XML_ERROR_JUNK_AFTER_DOC_ELEMENT:
      return "something follows the end of the root element";
    case XML_ERROR_UNDEFINED_ENTITY:
      return "it uses an entity (&name;) that it does not define";
    case XML_ERROR_RECURSIVE_ENTITY_REF:
      return "an entity contains itself";
    case XML_ERROR_ATTRIBUTE_EXTERNAL_ENTITY_REF:
      return "an attribute takes its text from another file by an entity";
    case XML_ERROR_AMPLIFICATION_LIMIT_BREACH:
      return "its entities grow too large when they are put in";
    case XML_ERROR_BAD_CHAR_REF:
      return "a number (&#...;) stands for no character";
    case XML_ERROR_UNKNOWN_ENCODING:
    case XML_ERROR_INCORRECT_ENCODING:
      return "its encoding is not known; save it as UTF-8";
    case XML_ERROR_MISPLACED_XML_PI:
      return "'<?xml' does not stand at its very beginning";
    case XML_ERROR_UNBOUND_PREFIX:
      return "a name has a prefix that is not declared";
    default:
      return "its markup breaks the rules of XML";
  }
}

inline std::string XmlWatch::why_stopped() const {
  if (!refusal_.empty()) return refusal_;
  const XML_Error fault = XML_GetErrorCode(parser_);
  if (fault == XML_ERROR_NO_MEMORY) throw std::bad_alloc();
  return fmt::format("is not well-formed XML: {}", in_words(fault));
}

}  // namespace borelli
