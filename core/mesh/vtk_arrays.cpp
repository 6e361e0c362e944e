#include "mesh/vtk_arrays.hpp"

#include <algorithm>
#include <array>

#include <fmt/format.h>
#include <zlib.h>

#include "mesh/cursor.hpp"

namespace springnet::meshes {
namespace {

constexpr std::array scalar_names{"Int8",   "UInt8", "Int16",  "UInt16",  "Int32",
                                  "UInt32", "Int64", "UInt64", "Float32", "Float64"};

// zlib's greatest expansion factor.
constexpr std::uint64_t max_expansion = 1032;

// Limits of memory: base_limit and so many bytes for each byte of the file. A number of one byte or two characters
// takes eight bytes in memory, arrays may share their data, and zlib compresses meshes to about a tenth.
constexpr std::uint64_t max_per_byte = 16, max_per_compressed_byte = 100, base_byte_limit = 1U << 24U;

int base64_digit(char c) noexcept {
  if (c >= 'A' && c <= 'Z') return c - 'A';
  if (c >= 'a' && c <= 'z') return c - 'a' + 26;
  if (c >= '0' && c <= '9') return c - '0' + 52;
  if (c == '+') return 62;
  return c == '/' ? 63 : -1;
}

// Decodes up to the first character that is not base64. VTK pads and concatenates pieces: header and data of a
// compressed array are two pieces.
std::string from_base64(std::string_view text) {
  std::string bytes;
  bytes.reserve(text.size() / 4 * 3);
  std::uint32_t group = 0;
  int digits = 0, padding = 0;
  for (const char c : text) {
    if (c == ' ' || (c >= '\t' && c <= '\r')) continue;
    const int digit = base64_digit(c);
    if (c != '=' && (digit < 0 || padding > 0)) break;
    if (c == '=') ++padding;
    group = group << 6U | static_cast<std::uint32_t>(c == '=' ? 0 : digit);
    if (++digits < 4) continue;
    for (int k = 0; k < 3 - padding; ++k) bytes += static_cast<char>(group >> (16 - 8 * k) & 0xFFU);
    group = 0;
    digits = padding = 0;
  }
  return bytes;
}

}  // namespace

Place ArrayReader::place(pugi::xml_node node) {
  return {static_cast<std::size_t>(std::max<std::ptrdiff_t>(node.offset_debug(), 0)), false};
}

// For messages: only names that VTK or this reader defines, since the file's may be anything.
std::string ArrayReader::name_of(pugi::xml_node array) {
  const std::string_view name = array.attribute("Name").value();
  if (name == "connectivity" || name == "offsets" || name == "types" || VtkCells::is_group_name(name)) {
    return fmt::format("array '{}'", name);
  }
  return array.parent().name() == std::string_view("Points") ? "the array of points" : "this array";
}

std::uint64_t ArrayReader::number(pugi::xml_node node, const char* attribute) const {
  const pugi::xml_attribute found = node.attribute(attribute);
  if (!found) fail(node, fmt::format("<{}> has no {}; export the mesh again", node.name(), attribute));
  std::string_view text = found.value();
  const std::size_t begin = text.find_first_not_of(' ');
  text = begin == std::string_view::npos ? "" : text.substr(begin, text.find_last_not_of(' ') + 1 - begin);
  std::uint64_t value = 0;
  if (!parse_integer(text, value)) {
    fail(node, fmt::format("{} of <{}> should be a whole number; correct it or export the mesh again", attribute,
                           node.name()));
  }
  return value;
}

Scalar ArrayReader::type(pugi::xml_node array) const {
  const std::string_view name = array.attribute("type").value();
  const auto found = std::find(scalar_names.begin(), scalar_names.end(), name);
  if (found == scalar_names.end()) {
    fail(array, fmt::format("{} has an unsupported type; export the mesh again", name_of(array)));
  }
  return static_cast<Scalar>(found - scalar_names.begin());
}

void ArrayReader::claim(pugi::xml_node array, std::uint64_t count, std::uint64_t bytes_each) {
  const std::uint64_t each = encoding_.compressed ? max_per_compressed_byte : max_per_byte;
  const std::uint64_t limit = base_byte_limit + source_.text().size() * each - claimed_;
  if (count > limit / bytes_each) {
    fail(array, fmt::format("{} declares {} values; together with the arrays before it this is more than the file can "
                            "hold; it is damaged, export it again",
                            name_of(array), count));
  }
  claimed_ += count * bytes_each;
}

std::vector<double> ArrayReader::reals(pugi::xml_node array, std::uint64_t count, std::uint64_t components) {
  return values<double>(array, count, components);
}
std::vector<std::int64_t> ArrayReader::integers(pugi::xml_node array, std::uint64_t count) {
  if (!is_integer(type(array))) {
    fail(array, fmt::format("{} must have whole numbers; export the mesh again", name_of(array)));
  }
  return values<std::int64_t>(array, count, 1);
}

template <class To>
std::vector<To> ArrayReader::values(pugi::xml_node array, std::uint64_t count, std::uint64_t components) {
  if (count == 0) return {};
  const std::string_view format = array.attribute("format").as_string("ascii");
  const bool is_text = format == "ascii";
  claim(array, count, components * sizeof(To));
  if (is_text) return text_values<To>(array, components * count);
  return decode<To>(type(array), data(array, count * components * size_of(type(array))), encoding_.swap);
}

template <class To>
std::vector<To> ArrayReader::text_values(pugi::xml_node array, std::uint64_t count) const {
  const std::string_view text = array.child_value();
  const pugi::xml_node content = array.first_child();
  const std::size_t begin = content ? place(content).offset : place(array).offset;
  std::vector<To> result;
  result.reserve(static_cast<std::size_t>(std::min<std::uint64_t>(count, text.size() / 2 + 1)));
  constexpr std::string_view spaces = " \t\n\r\v\f";
  for (std::size_t at = 0; (at = text.find_first_not_of(spaces, at)) != std::string_view::npos;) {
    const std::size_t end = std::min(text.find_first_of(spaces, at), text.size());
    const std::string_view word = text.substr(at, end - at);
    To value{};
    bool fine = false;
    if constexpr (std::is_same_v<To, double>) {
      fine = parse_real(word, value);
    } else {
      fine = parse_integer(word, value);
    }
    if (!fine) {
      source_.fail({begin + at, false},
                   fmt::format("this should be a{} number; correct the line or export the mesh again",
                               std::is_same_v<To, double> ? "" : " whole"));
    }
    result.push_back(value);
    at = end;
  }
  if (result.size() != count) {
    fail(array, fmt::format("{} has {} values and should have {}; the counts are wrong or the file is damaged, export "
                            "it again",
                            name_of(array), result.size(), count));
  }
  return result;
}

std::uint64_t ArrayReader::header_number(std::string_view encoded, std::size_t index) const {
  if (encoding_.wide_header) return from_bytes<std::uint64_t>(encoded.data() + 8 * index, encoding_.swap);
  return from_bytes<std::uint32_t>(encoded.data() + 4 * index, encoding_.swap);
}

std::string ArrayReader::data(pugi::xml_node array, std::uint64_t bytes) const {
  const std::string_view format = array.attribute("format").value();
  const std::string name = name_of(array);
  std::string decoded;
  std::string_view encoded;
  if (format == "binary") {
    decoded = from_base64(array.child_value());
    encoded = decoded;
  } else if (format == "appended") {
    const std::uint64_t offset = number(array, "offset");
    if (offset >= encoding_.appended.size()) {
      fail(array, fmt::format("{} begins at {} of the appended data, which has {} bytes; the file is cut off, export "
                              "it again",
                              name, offset, encoding_.appended.size()));
    }
    encoded = encoding_.appended.substr(static_cast<std::size_t>(offset));
    if (!encoding_.appended_raw) {
      // Base64 has four characters for three bytes; compressed data are at most slightly longer than the original, plus
      // the header.
      const std::uint64_t enough = bytes < encoded.size() ? 2 * bytes + bytes / 64 + 4096 : encoded.size();
      decoded = from_base64(encoded.substr(0, static_cast<std::size_t>(enough)));
      encoded = decoded;
    }
  } else {
    fail(array,
         fmt::format("{} has a format other than 'ascii', 'binary' and 'appended'; export the mesh again", name));
  }
  if (encoding_.compressed) return decompressed(array, encoded, bytes);

  const std::size_t header = encoding_.wide_header ? 8 : 4;
  if (encoded.size() < header) fail(array, fmt::format("{} is cut off; export the mesh again", name));
  const std::uint64_t size = header_number(encoded, 0);
  if (size != bytes || encoded.size() - header < bytes) {
    fail(array, fmt::format("{} should have {} bytes, but its header has {}, and {} follow; the file is damaged, "
                            "export it again",
                            name, bytes, size, encoded.size() - header));
  }
  return std::string(encoded.substr(header, static_cast<std::size_t>(bytes)));
}

// Layout: number of blocks, size of a block, size of the last one (0: as the others), compressed size of each; then the
// blocks.
std::string ArrayReader::decompressed(pugi::xml_node array, std::string_view encoded, std::uint64_t bytes) const {
  const auto check = [&](bool fine) {
    if (fine) return;
    fail(array,
         fmt::format(
             "the compressed data of {} are damaged or do not match the {} bytes that the counts require; export "
             "the mesh again",
             name_of(array), bytes));
  };
  const std::size_t word = encoding_.wide_header ? 8 : 4;
  check(encoded.size() >= 3 * word && bytes <= encoded.size() * max_expansion);
  const std::uint64_t blocks = header_number(encoded, 0), block_size = header_number(encoded, 1);
  const std::uint64_t last_size = header_number(encoded, 2);
  check(blocks > 0 && blocks <= encoded.size() / word - 3 && block_size > 0 && block_size <= bytes + (1U << 30U));
  check(last_size <= block_size);
  const std::uint64_t full_blocks = last_size == 0 ? blocks : blocks - 1;
  check(full_blocks <= bytes / block_size && full_blocks * block_size + last_size == bytes);
  std::string result(static_cast<std::size_t>(bytes), '\0');
  std::size_t at = static_cast<std::size_t>(3 + blocks) * word, done = 0;
  for (std::uint64_t block = 0; block < blocks; ++block) {
    const std::uint64_t size = header_number(encoded, static_cast<std::size_t>(3 + block));
    check(size <= encoded.size() - at);
    const std::uint64_t wanted = block < full_blocks ? block_size : last_size;
    auto made = static_cast<uLongf>(wanted);
    const int status = uncompress(reinterpret_cast<Bytef*>(result.data() + done), &made,
                                  reinterpret_cast<const Bytef*>(encoded.data() + at), static_cast<uLong>(size));
    check(status == Z_OK && made == wanted);
    at += static_cast<std::size_t>(size);
    done += static_cast<std::size_t>(wanted);
  }
  return result;
}

}  // namespace springnet::meshes
