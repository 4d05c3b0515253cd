// PCD files: the header is checked here, the rows are read by the plug-in.

#include <dlfcn.h>

#include <gpsrecon/core/error.h>
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <map>

#include "columns.h"
#include "formats.h"
#include "pcd_plugin.h"
#include "text.h"

namespace gpsrecon::internal::io {
namespace {

struct PcdHeader {
  std::size_t rows = 0;
  std::size_t row_bytes = 0;
  std::size_t row_numbers = 0;
  std::string encoding;
  std::optional<Vec3> sensor;
  std::size_t body_offset = 0;
  std::size_t body_first_line = 1;
};

// PCL trusts the numbers of a header; here they are compared with each other and with the size of the file before it
// sees them.
class HeaderReader {
 public:
  explicit HeaderReader(const InputFile& file) : file_(file), lines_(file.bytes()) {}

  PcdHeader read() {
    while (header_.encoding.empty()) {
      if (!lines_.next_filled('#')) fail("expected 'DATA' and the rows, found the end of the file");
      FieldReader fields(lines_.line());
      std::string_view keyword, field;
      fields.next(keyword);
      const auto known = {"VERSION", "FIELDS", "COLUMNS",   "SIZE",   "TYPE", "COUNT",
                          "WIDTH",   "HEIGHT", "VIEWPOINT", "POINTS", "DATA"};
      if (std::find(known.begin(), known.end(), keyword) == known.end())
        fail("expected a line of a PCD header (VERSION, FIELDS, SIZE, ...), found " + quote(lines_.line()));
      std::vector<std::string_view>& entries = entries_[std::string(keyword == "COLUMNS" ? "FIELDS" : keyword)];
      if (!entries.empty()) fail("expected one line " + quote(keyword) + " only");
      while (fields.next(field)) entries.push_back(field);
      if (keyword == "DATA") header_.encoding = entries.empty() ? "?" : entries.front();
    }
    header_.body_offset = file_.bytes().size() - lines_.remaining();
    header_.body_first_line = lines_.number() + 1;
    check_fields();
    check_rows();
    read_viewpoint();
    check_body();
    return header_;
  }

 private:
  [[noreturn]] void fail(const std::string& message) const { file_.fail_at_line(lines_.number(), message); }

  std::uint64_t number(std::string_view field, const std::string& what, std::uint64_t largest) const {
    std::int64_t value;
    if (!parse_integer(field, value) || value < 0 || static_cast<std::uint64_t>(value) > largest)
      fail("expected " + what + " in the header, found " + quote(field));
    return static_cast<std::uint64_t>(value);
  }

  void check_fields() {
    const std::vector<std::string_view>& fields = entries_["FIELDS"];
    const std::vector<std::string_view>& sizes = entries_["SIZE"];
    const std::vector<std::string_view>& types = entries_["TYPE"];
    const std::vector<std::string_view>& counts = entries_["COUNT"];
    if (fields.empty() || sizes.size() != fields.size() || types.size() != fields.size() ||
        (!counts.empty() && counts.size() != fields.size()))
      fail("expected one SIZE, TYPE and COUNT per field (" + std::to_string(fields.size()) + " fields) in the header");
    for (std::size_t f = 0; f < fields.size(); ++f) {
      const std::uint64_t size = number(sizes[f], "a SIZE of 1, 2, 4 or 8", 8);
      const bool known_type = types[f] == "F" ? size >= 4 : types[f] == "I" || types[f] == "U";
      if ((size != 1 && size != 2 && size != 4 && size != 8) || !known_type)
        fail("expected a TYPE I, U or F and a SIZE of 1, 2, 4 or 8 (F: 4 or 8), found " + quote(types[f]) + " and " +
             quote(sizes[f]));
      const std::uint64_t count = counts.empty() ? 1 : number(counts[f], "a COUNT", 1u << 20);
      if (count == 0) fail("expected a COUNT of at least 1, found 0");
      header_.row_bytes += size * count;
      header_.row_numbers += count;
    }
  }

  void check_rows() {
    const auto single = [this](const char* keyword, std::uint64_t fallback) {
      const std::vector<std::string_view>& entries = entries_[keyword];
      return entries.empty() ? fallback : number(entries.front(), keyword, 0xFFFFFFFEu);
    };
    if (entries_["WIDTH"].empty()) fail("expected a line 'WIDTH' in the header");
    header_.rows = single("WIDTH", 0) * single("HEIGHT", 1);
    if (single("POINTS", header_.rows) != header_.rows)
      fail("expected POINTS to be WIDTH times HEIGHT (" + std::to_string(header_.rows) + ") in the header");
  }

  void read_viewpoint() {
    const std::vector<std::string_view>& entries = entries_["VIEWPOINT"];
    if (entries.empty()) return;
    double numbers[7];
    for (std::size_t i = 0; i < 7; ++i)
      if (entries.size() != 7 || !parse_number(entries[i], numbers[i]))
        fail("expected seven numbers after VIEWPOINT in the header");
    const double unset[] = {0, 0, 0, 1, 0, 0, 0};
    if (!std::equal(std::begin(numbers), std::end(numbers), unset))
      header_.sensor = Vec3(numbers[0], numbers[1], numbers[2]);
  }

  void check_body() {
    const std::size_t available = file_.bytes().size() - header_.body_offset;
    const auto fail_truncated = [&](std::size_t bytes) {
      file_.fail_at_byte(file_.bytes().size(), "expected " + std::to_string(header_.rows) + " rows (" +
                                                   std::to_string(bytes) + " bytes), found the end of the file");
    };
    if (header_.encoding == "ascii") {
      check_text();
    } else if (header_.encoding == "binary") {
      if (header_.rows > available / header_.row_bytes) fail_truncated(header_.rows * header_.row_bytes);
    } else if (header_.encoding == "binary_compressed") {
      if (available < 8) fail_truncated(8);
      const char* const sizes = file_.bytes().data() + header_.body_offset;
      const std::uint64_t packed = load_little_endian(sizes), unpacked = load_little_endian(sizes + 4);
      if (packed > available - 8) fail_truncated(8 + packed);
      constexpr std::uint64_t largest_ratio = 100;  // LZF packs at most 264 bytes into 3
      if (unpacked > largest_ratio * packed)
        file_.fail_at_byte(header_.body_offset, "expected compressed data of " + std::to_string(unpacked) +
                                                    " bytes, found " + std::to_string(packed) + " to unpack");
      if (unpacked / header_.row_bytes != header_.rows || unpacked % header_.row_bytes != 0)
        file_.fail_at_byte(header_.body_offset + 4, "expected " + std::to_string(header_.rows) + " rows of " +
                                                        std::to_string(header_.row_bytes) + " bytes, found " +
                                                        std::to_string(unpacked) + " bytes");
    } else {
      fail("expected DATA ascii, binary or binary_compressed, found " + quote(header_.encoding));
    }
  }

  void check_text() {
    LineReader rows(file_.bytes().substr(header_.body_offset), header_.body_first_line);
    for (std::size_t row = 0; row < header_.rows; ++row) {
      if (!rows.next_filled('#'))
        file_.fail_at_line(rows.number(), "expected row " + std::to_string(row) + " (of " +
                                              std::to_string(header_.rows) + "), found the end of the file");
      FieldReader fields(rows.line());
      std::size_t count = 0;
      double value;
      for (std::string_view field; fields.next(field); ++count)
        if (!parse_number(field, value)) file_.fail_at_line(rows.number(), "expected a number, found " + quote(field));
      if (count != header_.row_numbers)
        file_.fail_at_line(rows.number(), "expected " + std::to_string(header_.row_numbers) + " numbers, found " +
                                              std::to_string(count));
    }
    if (rows.next_filled('#'))
      file_.fail_at_line(rows.number(), "expected the end of the file, found " + quote(rows.line()));
  }

  static std::uint64_t load_little_endian(const char* bytes) {
    std::uint64_t value = 0;
    for (int i = 3; i >= 0; --i) value = value << 8 | static_cast<unsigned char>(bytes[i]);
    return value;
  }

  const InputFile& file_;
  LineReader lines_;
  PcdHeader header_;
  std::map<std::string, std::vector<std::string_view>> entries_;
};

// Where the plug-in may be: where the user says, beside the program (in the build tree as in an installation), or where
// it was to be installed.
std::vector<std::filesystem::path> plugin_folders() {
  std::vector<std::filesystem::path> folders;
  if (const char* const set = std::getenv("GPSRECON_PLUGIN_DIR"); set != nullptr) folders.emplace_back(set);
  std::error_code error;
  const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", error);
  if (!error) folders.push_back(program.parent_path().parent_path() / GPSRECON_PLUGIN_SUBDIR);
  folders.emplace_back(GPSRECON_PLUGIN_INSTALL_DIR);
  return folders;
}

// Once loaded it stays loaded: libraries of that size do not unload cleanly.
GpsreconReadPcd* load_plugin(const InputFile& file) {
  constexpr const char* convert = "; convert the file with `pcl_pcd2ply in.pcd out.ply`";
  for (const std::filesystem::path& folder : plugin_folders()) {
    const std::filesystem::path plugin = folder / "gpsrecon_pcd.so";
    std::error_code error;
    if (!std::filesystem::exists(plugin, error)) continue;
    void* const library = ::dlopen(plugin.c_str(), RTLD_NOW | RTLD_LOCAL);
    void* const symbol = library != nullptr ? ::dlsym(library, "gpsrecon_read_pcd") : nullptr;
    if (symbol == nullptr) {
      const char* const reason = ::dlerror();
      file.fail(std::string("PCD files need a plug-in that cannot be loaded (") + (reason != nullptr ? reason : "?") +
                ")" + convert);
    }
    return reinterpret_cast<GpsreconReadPcd*>(symbol);
  }
  file.fail(std::string("PCD files need the plug-in gpsrecon_pcd.so, which is not installed") + convert);
}

void receive_table(void* context, const GpsreconPcdTable* received) {
  Table& table = *static_cast<Table*>(context);
  for (std::uint64_t c = 0; c < received->columns; ++c) {
    table.names.emplace_back(received->names[c]);
    table.columns.emplace_back(received->values[c], received->values[c] + received->rows);
  }
}

}  // namespace

PointCloud read_pcd(const InputFile& file) {
  const PcdHeader header = HeaderReader(file).read();
  GpsreconReadPcd* const read = load_plugin(file);
  Table table;
  char error[256] = "";
  if (header.rows > 0 && read(file.path().c_str(), receive_table, &table, error, sizeof(error)) != 0) file.fail(error);
  if (header.rows == 0) return {};
  const ColumnRoles roles = column_roles(table.names);
  if (!roles.position) file.fail("expected fields 'x', 'y', 'z'");
  if (table.rows() != header.rows)
    file.fail("expected " + std::to_string(header.rows) + " rows, found " + std::to_string(table.rows()));
  PointCloud cloud = cloud_of_table(std::move(table), roles);
  if (header.sensor) cloud.sensors.assign(cloud.size(), *header.sensor);
  return cloud;
}

}  // namespace gpsrecon::internal::io
