#include <array>

#include <fmt/format.h>
#include <zlib.h>

#include "samples.hpp"

namespace springnet::testing {
namespace {

constexpr std::array<int, 6> vtk_types{12, 13, 14, 10, 9, 1};
constexpr std::array<int, 6> materials{7, 7, 7, 7, 2, 2};

// Values in legacy VTK: text, or bytes with the highest first.
template <class T, class Values>
std::string legacy(bool binary, const Values& values) {
  std::string text;
  for (const auto value : values) {
    if (binary) {
      put<T>(text, static_cast<T>(value), true);
    } else {
      text += fmt::format("{} ", value);
    }
  }
  return text + "\n";
}

std::vector<double> coordinates(double height = 0.0) {
  std::vector<double> values;
  for (const Vector3& point : body_points()) values.insert(values.end(), {point.x(), point.y(), point.z() + height});
  return values;
}

std::vector<std::int64_t> connectivity(bool with_counts) {
  std::vector<std::int64_t> values;
  for (const SampleCell& cell : body_cells()) {
    if (with_counts) values.push_back(static_cast<std::int64_t>(cell.points.size()));
    values.insert(values.end(), cell.points.begin(), cell.points.end());
  }
  return values;
}

std::vector<std::int64_t> offsets(bool from_zero) {
  std::vector<std::int64_t> values(from_zero ? 1 : 0, 0);
  std::int64_t end = 0;
  for (const SampleCell& cell : body_cells()) values.push_back(end += static_cast<std::int64_t>(cell.points.size()));
  return values;
}

std::string legacy_body(bool binary, bool with_offsets) {
  const std::size_t cells = body_cells().size();
  std::string text = fmt::format("# vtk DataFile Version {}\ntitle of it\n{}\nDATASET UNSTRUCTURED_GRID\n",
                                 with_offsets ? "5.1" : "2.0", binary ? "BINARY" : "ASCII");
  text += "FIELD FieldData 1\nTIME 1 1 double\n" + legacy<double>(binary, std::array{0.5});
  text += fmt::format("POINTS {} float\n", body_points().size()) + legacy<float>(binary, coordinates());
  text += "METADATA\nINFORMATION 0\n\n";
  if (with_offsets) {
    text += fmt::format("CELLS {} {}\nOFFSETS vtktypeint64\n", cells + 1, connectivity(false).size());
    text += legacy<std::int64_t>(binary, offsets(true)) + "CONNECTIVITY vtktypeint64\n";
    text += legacy<std::int64_t>(binary, connectivity(false));
  } else {
    text += fmt::format("CELLS {} {}\n", cells, connectivity(true).size());
    text += legacy<std::int32_t>(binary, connectivity(true));
  }
  text += fmt::format("CELL_TYPES {}\n", cells) + legacy<std::int32_t>(binary, vtk_types);
  text += fmt::format("POINT_DATA {}\nVECTORS velocity float\n", body_points().size()) +
          legacy<float>(binary, coordinates());
  text += fmt::format("CELL_DATA {}\nSCALARS pressure double 1\nLOOKUP_TABLE mine\n", cells);
  text += legacy<double>(binary, vtk_types);
  text += "LOOKUP_TABLE mine 1\n" + (binary ? legacy<std::uint8_t>(true, std::array{1, 2, 3, 4}) : "0 0.5 1 1\n");
  text += fmt::format("FIELD FieldData 2\nnothing 2 {} short\n", cells);
  text += legacy<std::int16_t>(binary, std::array{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12});
  text += fmt::format("material 1 {} int\n", cells) + legacy<std::int32_t>(binary, materials);
  return text;
}

std::string base64(std::string_view bytes) {
  constexpr std::string_view digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      group = group << 8U | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0U);
    }
    for (std::size_t k = 0; k < 4; ++k) text += i + k <= bytes.size() ? digits[group >> (18 - 6 * k) & 63U] : '=';
  }
  return text;
}

enum class Format { text, base64, raw_appended, base64_appended };

class XmlWriter {
 public:
  XmlWriter(Format format, bool compressed, bool wide, bool big)
      : format_(format), compressed_(compressed), wide_(wide), big_(big) {}

  template <class T, class Values>
  std::string array(const char* type, const char* name, const Values& values, int components = 1) {
    std::string text = fmt::format("<DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"{}\"", type,
                                   name, components,
                                   format_ == Format::text     ? "ascii"
                                   : format_ == Format::base64 ? "binary"
                                                               : "appended");
    if (format_ == Format::text) {
      text += ">\n";
      for (const auto value : values) text += fmt::format(" {}", value);
      return text + "\n</DataArray>\n";
    }
    std::string bytes;
    for (const auto value : values) put<T>(bytes, static_cast<T>(value), big_);
    if (format_ == Format::base64) return text + ">\n  " + encoded(bytes, true) + "\n</DataArray>\n";
    text += fmt::format(" offset=\"{}\"/>\n", appended_.size());
    appended_ += encoded(bytes, format_ == Format::base64_appended);
    return text;
  }

  std::string file(const char* type, const std::string& piece) {
    std::string text = fmt::format(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"{}\" version=\"1.0\" byte_order=\"{}Endian\" "
        "header_type=\"UInt{}\"{}>\n<{}>\n{}</{}>\n",
        type, big_ ? "Big" : "Little", wide_ ? 64 : 32, compressed_ ? " compressor=\"vtkZLibDataCompressor\"" : "",
        type, piece, type);
    if (!appended_.empty()) {
      text += fmt::format("<AppendedData encoding=\"{}\">\n _{}\n</AppendedData>\n",
                          format_ == Format::raw_appended ? "raw" : "base64", appended_);
    }
    return text + "</VTKFile>\n";
  }

 private:
  void number(std::string& header, std::size_t value) const {
    if (wide_) {
      put<std::uint64_t>(header, value, big_);
    } else {
      put<std::uint32_t>(header, static_cast<std::uint32_t>(value), big_);
    }
  }

  std::string encoded(const std::string& bytes, bool as_base64) const {
    std::string header;
    if (!compressed_) {
      number(header, bytes.size());
      return as_base64 ? base64(header + bytes) : header + bytes;
    }
    constexpr std::size_t block = 64;
    const std::size_t blocks = (bytes.size() + block - 1) / block;
    number(header, blocks);
    number(header, block);
    number(header, bytes.size() % block);
    std::string data;
    for (std::size_t i = 0; i < blocks; ++i) {
      const std::string part = bytes.substr(i * block, block);
      uLongf size = compressBound(part.size());
      std::string small(size, '\0');
      compress(reinterpret_cast<Bytef*>(small.data()), &size, reinterpret_cast<const Bytef*>(part.data()), part.size());
      number(header, size);
      data += small.substr(0, size);
    }
    return as_base64 ? base64(header) + base64(data) : header + data;
  }

  Format format_;
  bool compressed_, wide_, big_;
  std::string appended_;
};

std::string xml_piece(XmlWriter& out, double height = 0.0) {
  std::string piece = fmt::format("<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n<PointData/>\n<CellData>\n",
                                  body_points().size(), body_cells().size());
  piece +=
      out.array<double>("Float64", "pressure", materials) + out.array<std::int32_t>("Int32", "material", materials);
  piece += "</CellData>\n<Points>\n" + out.array<float>("Float32", "Points", coordinates(height), 3) +
           "</Points>\n<Cells>\n";
  piece += out.array<std::int64_t>("Int64", "connectivity", connectivity(false));
  piece += out.array<std::int32_t>("Int32", "offsets", offsets(false));
  return piece + out.array<std::uint8_t>("UInt8", "types", vtk_types) + "</Cells>\n</Piece>\n";
}

std::string xml_body(Format format, bool compressed, bool wide, bool big) {
  XmlWriter out(format, compressed, wide, big);
  const std::string piece = xml_piece(out);
  return out.file("UnstructuredGrid", piece);
}

std::string two_pieces(Format format, bool compressed) {
  XmlWriter out(format, compressed, true, false);
  const std::string lower = xml_piece(out), upper = xml_piece(out, 10.0);
  return out.file("UnstructuredGrid", lower + upper);
}

}  // namespace

std::vector<Sample> vtk_legacy_samples() {
  return {{"body_2.vtk", legacy_body(false, false)},
          {"body_2_binary.vtk", legacy_body(true, false)},
          {"body_5.vtk", legacy_body(false, true)},
          {"body_5_binary.vtk", legacy_body(true, true)}};
}

std::vector<Sample> vtk_xml_samples() {
  std::vector<Sample> samples{{"body_text.vtu", xml_body(Format::text, false, false, false)}};
  for (const auto& [name, format] : {std::pair{"base64", Format::base64}, std::pair{"raw", Format::raw_appended},
                                     std::pair{"appended", Format::base64_appended}}) {
    for (const bool compressed : {false, true}) {
      for (const bool wide : {false, true}) {
        for (const bool big : {false, true}) {
          samples.push_back({fmt::format("body_{}{}{}{}.vtu", name, compressed ? "_zlib" : "", wide ? "_64" : "_32",
                                         big ? "_big" : "_little"),
                             xml_body(format, compressed, wide, big)});
        }
      }
    }
  }
  return samples;
}

std::vector<Sample> vtk_piece_samples() {
  return {{"pieces_text.vtu", two_pieces(Format::text, false)},
          {"pieces_zlib.vtu", two_pieces(Format::raw_appended, true)}};
}

// Points on a row and one above each: a vertex, a line of two parts, a pentagon and a strip of two triangles.
std::vector<Sample> vtk_polygon_samples() {
  constexpr std::array points{0, 0, 0, 1, 0, 0, 2, 0, 0, 3, 0, 0, 0, 1, 0, 1, 1, 0, 2, 1, 0, 3, 1, 0, 1, 2, 0};
  const std::string legacy_text =
      "# vtk DataFile Version 3.0\ntitle\nASCII\nDATASET POLYDATA\nPOINTS 9 int\n0 0 0 1 0 0 2 0 0 3 0 0 0 1 0 1 1 0 2 "
      "1 0 "
      "3 1 0 1 2 0\nTRIANGLE_STRIPS 1 5\n4 2 3 6 7\nPOLYGONS 1 6\n5 0 1 5 8 4\nVERTICES 1 2\n1 3\nLINES 1 4\n3 1 2 6\n"
      "CELL_DATA 4\nSCALARS group int\nLOOKUP_TABLE default\n1 2 3 4\n";
  XmlWriter out(Format::base64, true, false, false);
  std::string piece =
      "<Piece NumberOfPoints=\"9\" NumberOfVerts=\"1\" NumberOfLines=\"1\" NumberOfStrips=\"1\" "
      "NumberOfPolys=\"1\">\n<Points>\n";
  piece += out.array<std::int32_t>("Int32", "Points", points, 3) + "</Points>\n<CellData>\n";
  piece += out.array<std::int8_t>("Int8", "group", std::array{1, 2, 3, 4}) + "</CellData>\n";
  const auto cells = [&](const char* name, const std::vector<int>& list) {
    piece += fmt::format("<{}>\n", name) + out.array<std::int64_t>("Int64", "connectivity", list);
    piece += out.array<std::int64_t>("Int64", "offsets", std::array{list.size()}) + fmt::format("</{}>\n", name);
  };
  cells("Verts", {3});
  cells("Lines", {1, 2, 6});
  cells("Strips", {2, 3, 6, 7});
  cells("Polys", {0, 1, 5, 8, 4});
  return {{"polygons.vtk", legacy_text}, {"polygons.vtp", out.file("PolyData", piece + "</Piece>\n")}};
}

}  // namespace springnet::testing
