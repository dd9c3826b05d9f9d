#include "pipeline/export/certificate_hdf5.hpp"

#include <algorithm>

#include "pipeline/export/certificate_fields.hpp"

namespace borelli {
namespace {

const std::string group = "/certificate";

std::string attribute_name(std::string name) {
  std::replace(name.begin(), name.end(), '/', '_');
  return name;
}

template <class Row>
void write_table(Hdf5Writer& file, const std::string& name, const std::vector<Row>& rows) {
  visit_columns(static_cast<const Row*>(nullptr),
                [&](const char* column, auto field, const char* unit, Presence) {
                  write_column(file, name + "/" + column, rows, field, unit);
                });
}

template <class Row>
void read_table(Hdf5Fill& fill, const std::string& name, std::vector<Row>& rows) {
  bool counted = false;
  visit_columns(static_cast<const Row*>(nullptr), [&]<class Field>(const char* column, Field Row::*field,
                                                                   const char*, Presence presence) {
    const std::string path = name + "/" + column;
    if (presence == Presence::in_newer_files && !fill.holds(path)) return;
    if (!counted)
      rows.resize(std::is_same_v<Field, std::string> ? fill.texts(path).size() : fill.column(path).size());
    counted = true;
    read_column(fill, path, rows, field);
  });
}

}  // namespace

void write_certificate(Hdf5Writer& file, const Certificate& certificate) {
  file.group(group);
  visit_certificate(certificate, [&]<class T>(const char* name, const T& value, Presence) {
    if constexpr (std::is_same_v<T, std::string>)
      file.attribute(group, attribute_name(name), value);
    else
      file.attribute(group, attribute_name(name), static_cast<double>(value));
  });
  file.attribute(group, "vouches_for", vouches_for(certificate));
  write_table(file, group + "/events", certificate.events);
  file.texts(group + "/redundant", certificate.redundant);
  file.texts(group + "/notes", certificate.notes);
  write_table(file, group + "/conserved", certificate.conserved);
  write_table(file, group + "/residuals", certificate.residuals);
}

void read_certificate(Hdf5Fill& fill, Certificate& certificate) {
  visit_certificate(certificate, [&]<class T>(const char* field, T& value, Presence presence) {
    const std::string name = attribute_name(field);
    if constexpr (std::is_same_v<T, std::string>)
      value = presence == Presence::always ? fill.text_attribute(group, name)
                                           : fill.text_attribute_if_there(group, name);
    else
      value = fill.as<T>(name, presence == Presence::always
                                   ? fill.attribute(group, name)
                                   : fill.attribute_if_there(group, name, static_cast<double>(value)));
  });
  read_table(fill, group + "/events", certificate.events);
  certificate.redundant = fill.texts(group + "/redundant");
  certificate.notes = fill.texts(group + "/notes");
  read_table(fill, group + "/conserved", certificate.conserved);
  read_table(fill, group + "/residuals", certificate.residuals);
}

}  // namespace borelli
