// Points as rows of numbers.

#include <algorithm>
#include <cmath>

#include "columns.h"
#include "formats.h"
#include "text.h"

namespace gpsrecon::internal::io {
namespace {

// Commas may be decimal marks where semicolons separate; then they are no numbers and an error, not a wrong column.
char separator_of(std::string_view line) {
  if (line.find(';') != std::string_view::npos) return ';';
  return line.find(',') != std::string_view::npos ? ',' : ' ';
}

std::vector<std::string> fields_of(std::string_view line) {
  std::vector<std::string> result;
  FieldReader fields(line, separator_of(line));
  for (std::string_view field; fields.next(field);) result.emplace_back(field);
  return result;
}

// Strips blanks and the quotes that spreadsheets put around names.
std::string unquoted(std::string name) {
  if (name.size() >= 2 && name.front() == '"' && name.back() == '"') name = name.substr(1, name.size() - 2);
  return name;
}

// The text of a comment line; nothing if the line is not one.
std::optional<std::string_view> comment_of(std::string_view line) {
  const std::size_t begin = line.find_first_not_of(" \t");
  if (begin == std::string_view::npos) return {};
  line.remove_prefix(begin);
  if (line.starts_with("//")) return line.substr(2);
  if (line.starts_with('#')) return line.substr(1);
  return {};
}

// Column names of a header or comment line, if it names x, y and z.
std::vector<std::string> names_of(std::string_view line) {
  std::vector<std::string> names = fields_of(line);
  std::transform(names.begin(), names.end(), names.begin(), unquoted);
  return column_roles(names).position ? names : std::vector<std::string>{};
}

// A header line is all words. What begins like a number, though it may not be one, is a row to complain about.
bool are_words(const std::vector<std::string>& fields) {
  double number;
  return std::none_of(fields.begin(), fields.end(), [&number](const std::string& field) {
    return field.empty() || std::string_view("0123456789+-.").find(field.front()) != std::string_view::npos ||
           parse_number(field, number);
  });
}

struct Names {
  std::vector<std::string> names;  // empty if there are none
  bool certain = false;            // from a header line; a comment may look like names and be prose
};

// Moves to the first row.
bool find_first_row(LineReader& lines, Names& names) {
  bool header_seen = false;
  while (lines.next_filled()) {
    if (const auto comment = comment_of(lines.line())) {
      if (!header_seen) names = {names_of(*comment)};
      continue;
    }
    if (header_seen || !are_words(fields_of(lines.line()))) return true;
    header_seen = true;
    names = {names_of(lines.line()), true};
  }
  return false;
}

bool are_byte_colors(const Table& table) {
  bool above_one = false;
  for (std::size_t column = 3; column < 6; ++column)
    for (const double value : table.columns[column]) {
      if (!(value >= 0 && value <= 255) || std::trunc(value) != value) return false;
      above_one = above_one || value > 1;
    }
  return above_one;
}

std::vector<std::string> default_names(const Table& table) {
  const std::size_t count = table.columns.size();
  if (count == 6 && are_byte_colors(table)) return {"x", "y", "z", "red", "green", "blue"};
  if (count == 6) return {"x", "y", "z", "nx", "ny", "nz"};
  std::vector<std::string> names{"x", "y", "z"};
  while (names.size() < count) names.push_back(std::string("c").append(std::to_string(names.size())));
  return names;
}

}  // namespace

PointCloud read_xyz(const InputFile& file) {
  LineReader lines(file.bytes());
  Names names;
  Table table;
  if (!find_first_row(lines, names)) return {};
  const char separator = separator_of(lines.line());
  do {
    if (comment_of(lines.line())) continue;
    std::string_view row = lines.line();
    row = row.substr(0, std::min(row.find('#'), row.find("//")));
    FieldReader fields(row, separator);
    const bool first = table.rows() == 0;
    std::size_t column = 0;
    for (std::string_view field; fields.next(field); ++column) {
      double value;
      if (!parse_number(field, value))
        file.fail_at_line(lines.number(),
                          "expected a number in column " + std::to_string(column + 1) + ", found " + quote(field));
      if (first && column == table.columns.size()) table.columns.emplace_back();
      if (column < table.columns.size()) table.columns[column].push_back(value);
    }
    if (column < 3) file.fail_at_line(lines.number(), "expected at least 3 numbers, found " + std::to_string(column));
    if (column != table.columns.size())
      file.fail_at_line(lines.number(), "expected " + std::to_string(table.columns.size()) +
                                            " numbers as in the rows before, found " + std::to_string(column));
    if (first && names.certain && !names.names.empty() && names.names.size() != column)
      file.fail_at_line(lines.number(), "expected " + std::to_string(names.names.size()) +
                                            " numbers as the header names columns, found " + std::to_string(column));
  } while (lines.next_filled());
  table.names = names.names.size() == table.columns.size() ? names.names : default_names(table);
  const ColumnRoles roles = column_roles(table.names);
  return cloud_of_table(std::move(table), roles);
}

}  // namespace gpsrecon::internal::io
