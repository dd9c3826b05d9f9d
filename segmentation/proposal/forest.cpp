#include "segmentation/proposal/forest.hpp"

#include <fmt/core.h>
#include <zlib.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <numeric>
#include <optional>
#include <sstream>

namespace borelli {
namespace {

constexpr std::size_t most_bytes = std::size_t{1} << 28;
constexpr int deepest = 200;  // largest number of branches above a leaf
constexpr std::size_t most_classes = 64;

struct Header {
  std::vector<std::string> features, classes;
  std::map<std::string, double, std::less<>> deviations;
  std::size_t trees = 0, packed = 0, unpacked = 0;
  std::uint32_t crc = 0;
  std::size_t length = 0;  // of the header itself, bytes
};

std::vector<std::string> words_of(std::istringstream& line) {
  return {std::istream_iterator<std::string>(line), std::istream_iterator<std::string>()};
}

// The text lines before the packed bytes; empty if they are damaged.
std::optional<Header> parse_header(std::string_view bytes) {
  Header h;
  while (true) {
    const std::size_t end = bytes.find('\n', h.length);
    if (end == std::string_view::npos || end - h.length > 100000) return std::nullopt;
    std::istringstream line{std::string(bytes.substr(h.length, end - h.length))};
    h.length = end + 1;
    std::string key;
    line >> key;
    if (key == "features") {
      h.features = words_of(line);
    } else if (key == "classes") {
      h.classes = words_of(line);
    } else if (key == "deviation") {
      std::string name;
      double value = 0;
      if (!(line >> name >> value)) return std::nullopt;
      h.deviations[name] = value;
    } else if (key == "trees") {
      if (!(line >> h.trees)) return std::nullopt;
    } else if (key == "bytes") {
      if (!(line >> h.packed >> h.unpacked >> std::hex >> h.crc)) return std::nullopt;
      return h;
    } else if (key != "borelli-forest") {
      return std::nullopt;
    }
  }
}

bool plausible(const Header& h, std::size_t length) {
  return !h.features.empty() && h.features.size() < 255 && !h.classes.empty() &&
         h.classes.size() <= most_classes && h.trees > 0 && h.trees <= 10000 && h.unpacked > 0 &&
         h.unpacked <= most_bytes && h.packed == length - h.length;
}

}  // namespace

void Forest::add_up(std::span<const std::int16_t> row, std::span<std::uint32_t> sums) const {
  std::fill(sums.begin(), sums.end(), 0U);
  for (const std::uint32_t root : roots_) {
    std::uint32_t n = root;
    while (nodes_[n].feature != leaf_mark)
      n = row[nodes_[n].feature] <= nodes_[n].threshold ? n + 1 : nodes_[n].next;
    const std::uint8_t* const leaf = leaves_.data() + nodes_[n].next;
    for (std::size_t c = 0; c < sums.size(); ++c) sums[c] += leaf[c];
  }
}

Result<Forest> parse_forest(std::string_view bytes, const std::string& where) {
  constexpr std::string_view mark = "borelli-forest ";
  if (!bytes.starts_with(mark))
    return failure(where, "is not a forest: it does not begin with 'borelli-forest'");
  if (!bytes.starts_with("borelli-forest 1\n"))
    return failure(where, "is a forest of another version than 1; train it again with this program's script");
  const auto damaged = [&](const char* what) {
    return failure(where, fmt::format("is a damaged forest ({}); copy it again, or train it again", what));
  };
  const auto header = parse_header(bytes);
  if (!header) return damaged("a line of its header cannot be read");
  if (!plausible(*header, bytes.size())) return damaged("its header or length contradicts itself");
  std::vector<std::uint8_t> data(header->unpacked);
  uLongf unpacked = header->unpacked;
  const auto* const packed = reinterpret_cast<const Bytef*>(bytes.data() + header->length);
  if (uncompress(data.data(), &unpacked, packed, header->packed) != Z_OK || unpacked != header->unpacked)
    return damaged("its bytes cannot be decompressed");
  if (crc32(0, data.data(), static_cast<uInt>(data.size())) != header->crc)
    return damaged("its checksum differs");

  Forest out;
  out.features = header->features, out.classes = header->classes, out.deviations = header->deviations;
  const std::size_t classes = out.classes.size();
  std::size_t at = 0;
  for (std::size_t tree = 0; tree < header->trees; ++tree) {
    out.roots_.push_back(static_cast<std::uint32_t>(out.nodes_.size()));
    std::vector<std::uint32_t> waiting;  // branches whose right subtree follows later
    while (true) {
      if (at >= data.size()) return damaged("a tree ends too early");
      const std::uint8_t feature = data[at++];
      const bool leaf = feature == Forest::leaf_mark;
      if (at + (leaf ? classes : 2) > data.size()) return damaged("a tree ends too early");
      if (!leaf) {
        if (feature >= out.features.size()) return damaged("a branch uses an unknown feature");
        if (waiting.size() >= deepest) return damaged("a tree is too deep");
        const int threshold = data[at] | data[at + 1] << 8;
        waiting.push_back(static_cast<std::uint32_t>(out.nodes_.size()));
        out.nodes_.push_back({static_cast<std::int16_t>(threshold), feature, 0});
        at += 2;
        continue;
      }
      const auto first = data.begin() + static_cast<std::ptrdiff_t>(at);
      if (std::accumulate(first, first + static_cast<std::ptrdiff_t>(classes), 0) != 255)
        return damaged("a leaf's probabilities do not add up to 1");
      out.nodes_.push_back({0, Forest::leaf_mark, static_cast<std::uint32_t>(out.leaves_.size())});
      out.leaves_.insert(out.leaves_.end(), first, first + static_cast<std::ptrdiff_t>(classes));
      at += classes;
      if (waiting.empty()) break;
      out.nodes_[waiting.back()].next = static_cast<std::uint32_t>(out.nodes_.size());
      waiting.pop_back();
    }
  }
  if (at != data.size()) return damaged("bytes follow the last tree");
  return out;
}

Result<Forest> read_forest(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return bad_use(path, "cannot be read: give the path of a forest");
  const std::string bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  return parse_forest(bytes, path);
}

}  // namespace borelli
