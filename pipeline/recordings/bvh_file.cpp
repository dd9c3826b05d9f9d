#include "pipeline/recordings/bvh_file.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include "error/printable.hpp"
#include "pipeline/recordings/text_rows.hpp"
#include "process/input_file.hpp"
#include "process/memory.hpp"
#include "segmentation/files/header_text.hpp"

namespace borelli {
namespace {

constexpr std::size_t most_joints = 20000;
constexpr long most_joint_channels = 12;

// Words of the hierarchy: between blanks, and each brace on its own.
class BvhWords {
 public:
  BvhWords(std::string_view text, const std::string& file) : rows_(text), file_(file) {}

  /// The next word; empty at the end of the text.
  std::string_view next() {
    while (!skip_blanks())
      if (!next_row()) return {};
    const bool brace = rest_.front() == '{' || rest_.front() == '}';
    return take(brace ? 1 : std::min(rest_.find_first_of(" \t\r\v\f{}"), rest_.size()));
  }
  /// The rest of the line, to a brace if there is one.
  std::string_view rest_of_line() { return trimmed(take(std::min(rest_.find_first_of("{}"), rest_.size()))); }
  bool next_row() {
    if (!rows_.next()) return false;
    rest_ = rows_.line();
    return true;
  }
  std::string_view row() const { return rest_; }

  std::string where() const { return fmt::format("{}:{}", file_, rows_.number()); }
  tl::unexpected<Error> refuse(const std::string& what) const { return bad_use(where(), what); }
  /// "is 'WORD', expected ...", or that the file ends.
  tl::unexpected<Error> unexpected_word(std::string_view word, const std::string& expected) const {
    return word.empty() ? refuse("ends here, expected " + expected)
                        : refuse(fmt::format("has '{}', expected {}", printable(word), expected));
  }

 private:
  bool skip_blanks() {
    const std::size_t begin = rest_.find_first_not_of(" \t\r\v\f");
    rest_.remove_prefix(std::min(begin, rest_.size()));
    return !rest_.empty();
  }
  std::string_view take(std::size_t length) {
    const std::string_view word = rest_.substr(0, length);
    rest_.remove_prefix(length);
    return word;
  }

  TextRows rows_;
  std::string_view rest_;
  std::string file_;
};

std::optional<BvhChannel> channel_of(std::string_view word) {
  const std::string lower = lower_case(word);
  const bool rotation = lower.size() == 9 && lower.ends_with("rotation");
  if (!rotation && !(lower.size() == 9 && lower.ends_with("position"))) return std::nullopt;
  if (lower.front() < 'x' || lower.front() > 'z') return std::nullopt;
  return BvhChannel{rotation, lower.front() - 'x'};
}

class BvhReader {
 public:
  BvhReader(std::string_view text, const std::string& file)
      : words_(text, file), file_(file), bytes_(text.size()) {}

  Result<BvhMotion> read() {
    if (auto fine = read_hierarchy(); !fine) return tl::unexpected(fine.error());
    if (auto fine = name_end_sites(); !fine) return tl::unexpected(fine.error());
    if (auto fine = read_motion(); !fine) return tl::unexpected(fine.error());
    return std::move(out_);
  }

 private:
  Result<void> read_hierarchy() {
    if (const auto word = words_.next(); lower_case(word) != "hierarchy")
      return words_.unexpected_word(word, "HIERARCHY, the beginning of a BVH file");
    for (;;) {
      const std::string_view word = words_.next();
      const std::string key = lower_case(word);
      if (key == "motion" || word.empty()) {
        if (out_.joints.empty()) return words_.unexpected_word(word, "ROOT");
        has_motion_ = !word.empty();
        return {};
      }
      if (key != "root") return words_.unexpected_word(word, "ROOT or MOTION");
      if (auto fine = read_tree(); !fine) return fine;
    }
  }

  // A ROOT and all below it. Without recursion, which the depth of a file could overflow.
  Result<void> read_tree() {
    if (auto fine = open_joint(false); !fine) return fine;
    while (!open_.empty()) {
      const std::string_view word = words_.next();
      const std::string key = lower_case(word);
      BvhJoint& joint = out_.joints[static_cast<std::size_t>(open_.back())];
      Result<void> fine;
      if (key == "}")
        fine = close_joint();
      else if (key == "offset")
        fine = read_offset(joint);
      else if (key == "channels" && !joint.end_site)
        fine = read_channels(joint);
      else if (key == "joint" && !joint.end_site)
        fine = open_joint(false);
      else if (key == "end" && !joint.end_site)
        fine = open_joint(true);
      else
        return words_.unexpected_word(word, joint.end_site
                                                ? "OFFSET or a closing brace"
                                                : "OFFSET, CHANNELS, JOINT, End Site or a closing brace");
      if (!fine) return fine;
    }
    return {};
  }

  Result<void> open_joint(bool end_site) {
    BvhJoint joint;
    joint.parent = open_.empty() ? -1 : open_.back();
    joint.end_site = end_site;
    const std::string_view name = words_.rest_of_line();
    if (!end_site) joint.name = name;
    if (!end_site && name.empty()) return words_.refuse("has a joint without a name, expected one");
    if (end_site && !lower_case(name).starts_with("site")) return words_.unexpected_word("End", "End Site");
    if (!end_site && !names_.insert(joint.name).second)
      return words_.refuse(fmt::format("lists the joint '{}' twice; remove one", printable(name)));
    if (const auto brace = words_.next(); brace != "{")
      return words_.unexpected_word(brace, "an opening brace");
    if (out_.joints.size() >= most_joints)
      return words_.refuse(fmt::format("has more than {} joints, the limit", most_joints));
    open_.push_back(static_cast<int>(out_.joints.size()));
    has_offset_.push_back(false);
    out_.joints.push_back(std::move(joint));
    return {};
  }

  Result<void> close_joint() {
    if (!has_offset_.back())
      return words_.refuse(fmt::format("ends {} before its OFFSET", described(open_.back())));
    open_.pop_back();
    has_offset_.pop_back();
    return {};
  }

  std::string described(int index) const {
    const BvhJoint& joint = out_.joints[static_cast<std::size_t>(index)];
    return joint.end_site ? "an End Site" : fmt::format("the joint '{}'", printable(joint.name));
  }

  Result<void> read_offset(BvhJoint& joint) {
    if (has_offset_.back())
      return words_.refuse(fmt::format("gives {} two OFFSETs, expected one", described(open_.back())));
    for (double& part : joint.offset) {
      const std::string_view word = words_.next();
      const auto number = finite_number(word);
      if (!number) return words_.unexpected_word(word, "the three numbers of an OFFSET");
      part = *number;
    }
    has_offset_.back() = true;
    return {};
  }

  Result<void> read_channels(BvhJoint& joint) {
    if (!joint.channels.empty())
      return words_.refuse(
          fmt::format("gives {} two lists of CHANNELS, expected one", described(open_.back())));
    const std::string_view number = words_.next();
    const auto count = integer_number(number);
    if (!count || *count < 0 || *count > most_joint_channels)
      return words_.unexpected_word(number,
                                    fmt::format("a count of channels from 0 to {}", most_joint_channels));
    bool placed[3] = {};
    for (long i = 0; i < *count; ++i) {
      const std::string_view word = words_.next();
      const auto channel = channel_of(word);
      if (!channel)
        return words_.unexpected_word(
            word, fmt::format("{} channels, each X, Y or Z with 'position' or 'rotation'", *count));
      if (!channel->rotation && std::exchange(placed[channel->axis], true))
        return words_.refuse(
            fmt::format("gives {} the channel '{}' twice", described(open_.back()), printable(word)));
      joint.channels.push_back(*channel);
    }
    return {};
  }

  // Joints are named apart from all others, so that each can be a marker.
  Result<void> name_end_sites() {
    for (BvhJoint& joint : out_.joints) {
      if (!joint.end_site) continue;
      joint.name = out_.joints[static_cast<std::size_t>(joint.parent)].name + "_end";
      for (int next = 2; !names_.insert(joint.name).second; ++next)
        joint.name = fmt::format("{}_end{}", out_.joints[static_cast<std::size_t>(joint.parent)].name, next);
    }
    return {};
  }

  // The value after "KEY:", with or without the colon and a blank.
  Result<double> setting(const std::vector<std::string>& keys, const std::string& expected) {
    std::string_view value;
    for (const std::string& key : keys) {
      const std::string_view word = words_.next();
      if (!lower_case(word).starts_with(key)) return words_.unexpected_word(word, expected);
      value = word.substr(key.size());
    }
    if (value.starts_with(':')) value.remove_prefix(1);
    if (value.empty()) value = words_.next();
    if (value == ":") value = words_.next();
    const auto number = finite_number(value);
    if (!number) return words_.unexpected_word(value, expected);
    return *number;
  }

  Result<void> read_motion() {
    const Eigen::Index channels = out_.first_channels().back();
    out_.values.resize(0, channels);
    if (!has_motion_) {
      out_.warnings.emplace_back("The file contains a skeleton but no MOTION.");
      return {};
    }
    const auto frames = setting({"frames"}, "Frames: and their number");
    if (!frames) return tl::unexpected(frames.error());
    const auto time = setting({"frame", "time"}, "Frame Time: and the seconds of a frame");
    if (!time) return tl::unexpected(time.error());
    if (*frames < 0) return words_.refuse(fmt::format("has {:g} frames, expected 0 or more", *frames));
    if (!(*time > 0))
      return words_.refuse(fmt::format("has the frame time {:g} s, expected a positive number", *time));
    out_.frame_time = *time;
    if (auto fits = admit_memory(file_, "its motion", 8.0 * static_cast<double>(bytes_)); !fits) return fits;
    auto numbers = read_rows(channels);
    if (!numbers) return tl::unexpected(numbers.error());
    const Eigen::Index count = channels > 0 ? std::ssize(*numbers) / channels : 0;
    using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    out_.values = Eigen::Map<const RowMajor>(numbers->data(), count, channels);
    if (*frames != static_cast<double>(count))
      out_.warnings.push_back(fmt::format(
          "MOTION announces {:g} frames, but the file contains {}; those were read.", *frames, count));
    return {};
  }

  Result<std::vector<double>> read_rows(Eigen::Index channels) {
    std::vector<double> numbers;
    do {
      const auto row = blank_words(words_.row());
      if (row.empty()) continue;
      if (std::ssize(row) != channels)
        return words_.refuse(fmt::format("has {} numbers, expected {}: one per channel of the hierarchy",
                                         row.size(), channels));
      for (const std::string_view word : row) {
        const auto number = finite_number(word);
        if (!number)
          return words_.refuse(
              fmt::format("has '{}', expected a number with a decimal point", printable(word)));
        numbers.push_back(*number);
      }
    } while (words_.next_row());
    return numbers;
  }

  BvhWords words_;
  std::string file_;
  std::size_t bytes_;
  BvhMotion out_;
  std::vector<int> open_;         // from the root to the joint being read
  std::vector<bool> has_offset_;  // likewise
  std::set<std::string> names_;
  bool has_motion_ = false;
};

}  // namespace

std::vector<Eigen::Index> BvhMotion::first_channels() const {
  std::vector<Eigen::Index> first{0};
  for (const BvhJoint& joint : joints) first.push_back(first.back() + std::ssize(joint.channels));
  return first;
}

Result<BvhMotion> parse_bvh(std::string_view text, const std::string& file) {
  return BvhReader(text, file).read();
}

Result<BvhMotion> read_bvh(const std::filesystem::path& path) {
  const auto text = read_input_file(path);
  if (!text) return tl::unexpected(text.error());
  return parse_bvh(*text, path.string());
}

}  // namespace borelli
