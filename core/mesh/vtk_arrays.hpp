// The DataArray elements of VTK's XML files, in all encodings.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <pugixml.hpp>

#include "mesh/source.hpp"
#include "mesh/vtk_cells.hpp"

namespace springnet::meshes {

// How a file encodes its arrays.
struct ArrayEncoding {
  bool swap = false;         // the file's byte order differs from the machine's
  bool wide_header = false;  // header numbers have 64 bits, not 32
  bool compressed = false;   // zlib
  bool appended_raw = false;
  std::string_view appended{};     // the data after the underscore of AppendedData
  std::size_t appended_begin = 0;  // its offset in the file
};

class ArrayReader {
 public:
  ArrayReader(const Source& source, const ArrayEncoding& encoding) : source_(source), encoding_(encoding) {}

  // Read `count` times `components` values. Throw Error(input) if the number differs, a value is out of range, the data
  // are damaged, or all arrays read so far together claim more than the file can hold (arrays may share data, so that
  // each alone would pass).
  [[nodiscard]] std::vector<double> reals(pugi::xml_node array, std::uint64_t count, std::uint64_t components = 1);
  [[nodiscard]] std::vector<std::int64_t> integers(pugi::xml_node array, std::uint64_t count);

  [[nodiscard]] static Place place(pugi::xml_node node);
  [[noreturn]] void fail(pugi::xml_node node, std::string_view message) const { source_.fail(place(node), message); }
  // An attribute that is a whole number, 0 or more.
  [[nodiscard]] std::uint64_t number(pugi::xml_node node, const char* attribute) const;
  [[nodiscard]] Scalar type(pugi::xml_node array) const;

 private:
  template <class To>
  std::vector<To> values(pugi::xml_node array, std::uint64_t count, std::uint64_t components);
  void claim(pugi::xml_node array, std::uint64_t count, std::uint64_t bytes_each);
  template <class To>
  std::vector<To> text_values(pugi::xml_node array, std::uint64_t count) const;
  // The bytes of an array, without its header.
  std::string data(pugi::xml_node array, std::uint64_t bytes) const;
  std::string decompressed(pugi::xml_node array, std::string_view encoded, std::uint64_t bytes) const;
  [[nodiscard]] static std::string name_of(pugi::xml_node array);
  [[nodiscard]] std::uint64_t header_number(std::string_view encoded, std::size_t index) const;

  const Source& source_;
  ArrayEncoding encoding_;
  std::uint64_t claimed_ = 0;  // bytes, of all arrays so far
};

}  // namespace springnet::meshes
