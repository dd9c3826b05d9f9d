#include "pipeline/recordings/motion_table_file.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <set>

#include "error/printable.hpp"
#include "pipeline/files/whole_file.hpp"
#include "pipeline/recordings/text_rows.hpp"
#include "process/input_file.hpp"
#include "process/memory.hpp"
#include "segmentation/files/header_text.hpp"

namespace borelli {
namespace {

constexpr std::size_t most_columns = 100000;

// A header line "key=value" or "key value": OpenSim takes blanks and equal signs alike.
struct HeaderLine {
  std::string key;  // in lower case
  std::string_view value;
};

HeaderLine header_line(std::string_view line) {
  const std::size_t end = std::min(line.find_first_of(" \t="), line.size());
  const std::size_t value = line.find_first_not_of(" \t=", end);
  return {lower_case(line.substr(0, end)), value == line.npos ? "" : trimmed(line.substr(value))};
}

// A title without control characters, blanks around it, and byte-order marks before it: at the start of a
// file, readers drop these.
std::string plain_title(std::string_view title) {
  constexpr std::string_view mark = "\xEF\xBB\xBF";
  std::string line(title);
  std::ranges::replace_if(
      line, [](unsigned char c) { return c < ' '; }, ' ');
  std::string_view rest = trimmed(line);
  while (rest.starts_with(mark)) rest = trimmed(rest.substr(mark.size()));
  return std::string(rest);
}

bool is_header_key(const std::string& key) {
  static const std::set<std::string, std::less<>> keys{
      "name",  "nr",        "nrows", "datarows",    "nc",        "ncolumns", "version",        "datatype",
      "range", "otherdata", "units", "datacolumns", "indegrees", "angles",   "opensimversion", "endheader"};
  return keys.contains(key) || key.starts_with('#');
}

class MotionTableReader {
 public:
  MotionTableReader(std::string_view text, const std::string& file) : text_(text), rows_(text), file_(file) {}

  Result<MotionTableFile> read() {
    for (const auto step :
         {&MotionTableReader::read_header, &MotionTableReader::read_columns, &MotionTableReader::check_size,
          &MotionTableReader::read_rows, &MotionTableReader::set_times, &MotionTableReader::finish})
      if (auto fine = (this->*step)(); !fine) return tl::unexpected(fine.error());
    return std::move(out_);
  }

 private:
  std::string where() const { return fmt::format("{}:{}", file_, rows_.number()); }
  tl::unexpected<Error> refuse(const std::string& what) const { return bad_use(where(), what); }

  Result<void> read_header() {
    for (bool first = true; rows_.next();) {
      const std::string_view line = trimmed(rows_.line());
      if (line.empty()) continue;
      const HeaderLine at = header_line(line);
      if (at.key == "endheader") return {};
      if (auto fine = take(at, line); !fine) return fine;
      if (first && !is_header_key(at.key)) out_.table.name = plain_title(line);
      first = false;
    }
    return bad_use(file_, "has no line 'endheader'; expected a table as OpenSim writes it (.mot, .sto)");
  }

  // One line of the header.
  Result<void> take(const HeaderLine& at, std::string_view line) {
    if (at.key == "name") {
      out_.table.name = plain_title(at.value);
    } else if (at.key == "nr" || at.key == "nrows" || at.key == "datarows") {
      return take_count(at, rows_told_);
    } else if (at.key == "nc" || at.key == "ncolumns" || at.key == "datacolumns") {
      return take_count(at, columns_told_);
    } else if (at.key == "version") {
      has_version_ = finite_number(at.value).value_or(0) >= 1;
    } else if (at.key == "datatype") {
      if (lower_case(at.value) != "double")
        return refuse(
            fmt::format("says DataType={}, expected a table of plain numbers (double)", printable(at.value)));
    } else if (at.key == "indegrees") {
      const std::string answer = lower_case(at.value);
      if (answer != "yes" && answer != "y" && answer != "no" && answer != "n")
        return refuse(fmt::format("says inDegrees={}, expected yes or no", printable(at.value)));
      in_degrees_ = answer.front() == 'y';
    } else if (at.key == "range") {
      return take_range(at.value);
    } else if (line == "Angles are in degrees.") {
      remark_on_degrees_ = true;
    } else if (line == "Angles are in radians.") {
      remark_on_degrees_ = false;
    }
    return {};
  }

  Result<void> take_count(const HeaderLine& at, std::optional<double>& count) {
    count = finite_number(at.value);
    if (!count || *count < 0)
      return refuse(fmt::format("says {} is '{}', expected a count", printable(at.key), printable(at.value)));
    return {};
  }

  Result<void> take_range(std::string_view value) {
    const auto words = blank_words(value);
    const auto start = words.size() == 2 ? finite_number(words[0]) : std::nullopt;
    const auto end = words.size() == 2 ? finite_number(words[1]) : std::nullopt;
    if (!start || !end || *end < *start)
      return refuse(fmt::format("says range is '{}', expected its start and end in s", printable(value)));
    range_ = {*start, *end};
    return {};
  }

  Result<void> read_columns() {
    while (rows_.next() && rows_.is_blank()) {
    }
    const auto names = column_names();
    if (names.empty() || rows_.is_blank()) return bad_use(file_, "ends before its line of column names");
    if (names.size() > most_columns)
      return refuse(fmt::format("has {} columns, expected at most {}", names.size(), most_columns));
    std::set<std::string_view> seen;
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (!seen.insert(names[i]).second)
        return refuse(fmt::format("has two columns '{}'; rename one", printable(names[i])));
      if (!time_ && lower_case(names[i]) == "time")
        time_ = i;
      else
        out_.table.columns.emplace_back(names[i]);
    }
    width_ = names.size();
    if (!time_ && !range_)
      return refuse(fmt::format("has '{}' as its first column, expected 'time'", printable(names[0])));
    if (columns_told_ && *columns_told_ != static_cast<double>(width_))
      out_.warnings.push_back(fmt::format(
          "The header announces {:g} columns, but {} are named; those were read.", *columns_told_, width_));
    return {};
  }

  // Names stand between tabs and may hold blanks, unless the first row has as many numbers as there are
  // words.
  std::vector<std::string_view> column_names() const {
    const auto words = blank_words(rows_.line());
    auto names = tab_cells(rows_.line());
    std::erase(names, std::string_view());
    TextRows ahead = rows_;
    while (ahead.next() && ahead.is_blank()) {
    }
    return names.size() > 1 && blank_words(ahead.line()).size() != words.size() ? names : words;
  }

  // A number and its separator take two bytes or more, so the table has at most four times the file's bytes.
  Result<void> check_size() {
    return admit_memory(file_, "its table", 8 * static_cast<double>(text_.size()));
  }

  Result<void> read_rows() {
    while (rows_.next()) {
      if (rows_.is_blank()) continue;
      auto cells = tab_cells(rows_.line());
      const bool blanks_within = std::ranges::any_of(
          cells, [](std::string_view cell) { return cell.find(' ') != std::string_view::npos; });
      if (cells.size() != width_ || blanks_within) {
        const auto words = blank_words(rows_.line());
        if (words.size() == width_ || cells.size() == 1) cells = words;
      }
      // (tab_cells leaves out empty cells at the end, which are gaps here)
      if (cells.size() < width_ &&
          std::ranges::count(rows_.line(), '\t') + 1 >= static_cast<std::ptrdiff_t>(width_))
        cells.resize(width_);
      if (cells.size() != width_)
        return refuse(fmt::format("has {} numbers, expected {}: one per column", cells.size(), width_));
      for (std::size_t i = 0; i < width_; ++i)
        if (auto fine = take_number(cells[i], i); !fine) return fine;
      row_lines_.push_back(rows_.number());
      drop_repeated_row();
    }
    if (row_lines_.empty()) return bad_use(file_, "contains no row below its column names");
    return {};
  }

  // OpenSim writes the last state of some simulations twice.
  void drop_repeated_row() {
    auto& times = out_.table.times;
    if (times.size() < 2 || times.back() != times[times.size() - 2]) return;
    times.pop_back();
    numbers_.resize(numbers_.size() - out_.table.columns.size());
    row_lines_.pop_back();
    ++repeated_;
  }

  Result<void> take_number(std::string_view cell, std::size_t column) {
    const auto number = is_gap(cell) ? std::numeric_limits<double>::quiet_NaN() : finite_number(cell);
    const std::string name =
        time_ == column ? "time" : out_.table.columns[column - (time_ && column > *time_)];
    if (!number || (time_ == column && std::isnan(*number)))
      return refuse(fmt::format("{} is '{}', expected a number with a decimal point{}", printable(name),
                                printable(cell), time_ == column ? "" : ", or nan"));
    (time_ == column ? out_.table.times : numbers_).push_back(*number);
    return {};
  }

  Result<void> set_times() {
    auto& times = out_.table.times;
    const std::size_t count = row_lines_.size();
    if (!time_) {
      if (count > 1 && !(range_->second > range_->first))
        return bad_use(file_, fmt::format("has {} rows, but its time range is zero", count));
      for (std::size_t i = 0; i < count; ++i)
        times.push_back(count == 1
                            ? range_->first
                            : range_->first + (range_->second - range_->first) * static_cast<double>(i) /
                                                  static_cast<double>(count - 1));
    }
    for (std::size_t i = 1; i < count; ++i)
      if (!(times[i] > times[i - 1]))
        return bad_use(fmt::format("{}:{}", file_, row_lines_[i]),
                       fmt::format("has the time {} s, expected more than the {} s of the row before",
                                   exact(times[i]), exact(times[i - 1])));
    return {};
  }

  Result<void> finish() {
    const std::size_t count = row_lines_.size();
    if (repeated_ > 0)
      out_.warnings.push_back(fmt::format(
          "{} rows repeat the time of the row before; the first row of each time was kept.", repeated_));
    if (rows_told_ && *rows_told_ != static_cast<double>(count + repeated_))
      out_.warnings.push_back(fmt::format(
          "The header announces {:g} rows, but the file contains {}; those were read.", *rows_told_, count));
    using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    out_.table.values = Eigen::Map<const RowMajor>(numbers_.data(), static_cast<Eigen::Index>(count),
                                                   std::ssize(out_.table.columns));
    const bool is_mot = lower_case(file_).ends_with(".mot");
    const bool in_degrees = in_degrees_.value_or(has_version_ ? false : remark_on_degrees_.value_or(is_mot));
    out_.table.in_degrees = in_degrees;
    return {};
  }

  std::string_view text_;
  TextRows rows_;
  std::string file_;
  MotionTableFile out_;
  std::optional<double> rows_told_, columns_told_;
  std::optional<bool> in_degrees_, remark_on_degrees_;
  std::optional<std::pair<double, double>> range_;
  bool has_version_ = false;
  std::optional<std::size_t> time_;  // its column
  std::size_t width_ = 0;            // cells in a row
  std::vector<double> numbers_;      // row by row, without the time
  std::vector<int> row_lines_;
  std::size_t repeated_ = 0;  // rows dropped
};

Result<void> check_motion_table(const MotionTable& table, const std::string& name) {
  const auto refuse = [&](const std::string& what) { return failure(name, "cannot be written: " + what); };
  if (table.times.empty() || table.values.rows() != std::ssize(table.times) ||
      table.values.cols() != std::ssize(table.columns))
    return refuse(fmt::format("its {} times and {} names do not fit {} by {} values", table.times.size(),
                              table.columns.size(), table.values.rows(), table.values.cols()));
  std::set<std::string_view> seen;
  for (const std::string& column : table.columns)
    if (column.empty() || column.find_first_of(" \t\r\n\v\f") != column.npos ||
        lower_case(column) == "time" || !seen.insert(column).second)
      return refuse(
          fmt::format("the column name '{}' is empty, doubled, 'time', or holds blanks, where "
                      "OpenSim would cut it",
                      printable(column)));
  for (std::size_t i = 0; i < table.times.size(); ++i)
    if (!std::isfinite(table.times[i]) || (i > 0 && !(table.times[i] > table.times[i - 1])))
      return refuse(fmt::format("the time of row {} does not rise", i + 1));
  if (table.values.array().isInf().any()) return refuse("it holds an infinite value");
  return {};
}

// The title as one line that no reader takes for a key.
std::string title_line(const std::string& title) {
  const std::string line = plain_title(title);
  if (line.empty()) return "";
  return (is_header_key(header_line(line).key) ? "name " : "") + line + "\n";
}

}  // namespace

Result<MotionTableFile> parse_motion_table(std::string_view text, const std::string& file) {
  return MotionTableReader(text, file).read();
}

Result<MotionTableFile> read_motion_table(const std::filesystem::path& path) {
  const auto text = read_input_file(path);
  if (!text) return tl::unexpected(text.error());
  return parse_motion_table(*text, path.string());
}

Result<std::string> motion_table_text(const MotionTable& table, const std::string& name) {
  if (auto fine = check_motion_table(table, name); !fine) return tl::unexpected(fine.error());
  std::string out = title_line(table.name) +
                    fmt::format(
                        "version=1\nnRows={}\nnColumns={}\ninDegrees={}\n\nUnits are S.I. units (second, "
                        "meters, Newtons, ...)\n{}\nendheader\ntime",
                        table.times.size(), table.columns.size() + 1, table.in_degrees ? "yes" : "no",
                        table.in_degrees ? "Angles are in degrees.\n" : "");
  for (const std::string& column : table.columns) out += "\t" + column;
  out += '\n';
  for (std::size_t i = 0; i < table.times.size(); ++i) {
    out += exact(table.times[i]);
    for (const double value : table.values.row(static_cast<Eigen::Index>(i)))
      out += "\t" + (std::isnan(value) ? std::string("nan") : exact(value));
    out += '\n';
  }
  return out;
}

Result<void> write_motion_table(const MotionTable& table, const std::filesystem::path& path) {
  const auto text = motion_table_text(table, path.string());
  if (!text) return tl::unexpected(text.error());
  return write_bytes(path, *text);
}

}  // namespace borelli
