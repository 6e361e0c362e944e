// Files that may be private or hostile: errors quote nothing of them, and they cost no more than their size warrants.
#include <doctest/doctest.h>

#include <ctime>
#include <set>

#include <fmt/format.h>
#include <springnet/error.hpp>

#include "facts.hpp"
#include "samples.hpp"

namespace springnet::testing {
namespace {

TEST_CASE("nothing of a refused file is quoted") {
  const std::string secret = "Xyzzy";
  std::size_t refused = 0;
  const TemporaryFolder folder;
  const auto check = [&](const std::string& name, const std::string& bytes) {
    folder.write(name, bytes);
    try {
      static_cast<void>(read_mesh(folder.path() / name));
    } catch (const Error& error) {
      const std::string message = error.what();
      CAPTURE(message);
      CHECK(message.find(secret) == std::string::npos);
      ++refused;
    }
  };
  for (const Sample& sample : all_samples()) {
    CAPTURE(sample.name);
    const std::string& bytes = sample.bytes;
    constexpr std::string_view between = " \n\r\t\"<>=/";
    std::set<std::string> words;
    for (std::size_t begin = 0, end = 0; words.size() < 200; begin = end) {
      begin = bytes.find_first_not_of(between, begin);
      if (begin == std::string::npos) break;
      end = std::min(bytes.find_first_of(between, begin), bytes.size());
      const std::string word = bytes.substr(begin, end - begin);
      if (!words.insert(word).second) continue;
      CAPTURE(word);
      check(sample.name, std::string(bytes).replace(begin, word.size(), secret));
      check(sample.name, std::string(bytes).insert(begin, secret + " "));
    }
    check(sample.name, secret + "\n");
  }
  CHECK(refused > 1000);
  // Lines that begin like the format's.
  check("a.obj", "user Xyzzy\nhost Xyzzy\n");
  check("a.obj", "Xyzzy Xyzzy Xyzzy\n");
  check("a.obj", "curv Xyzzy\ng Xyzzy\no Xyzzy\nv 0 0 0\n");
  check("a.stl", "solid Xyzzy\nendsolid Xyzzy\n");
  check("a.msh", "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Xyzzy\n$EndXyzzy\n$Nodes\n0 0 0 0\n$EndNodes\n");
  check("a.msh", "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Xyzzy\n");
  const std::string keywords = "# vtk DataFile Version 3.0\nXyzzy\nASCII\nDATASET POLYDATA\nPOINT_DATA 0\n";
  check("a.vtk", keywords + "Xyzzy Xyzzy\n");
  check("a.vtk", keywords + "SCALARS Xyzzy Xyzzy\n");
  // Words that OBJ may have, but this reader does not know, are counted and not named.
  const std::string message = error_of("a.obj", "xyzzy\n");
  CHECK(message.find("xyzzy") == std::string::npos);
  CHECK(message.find("1 statement is not read") != std::string::npos);
}

TEST_CASE("notes show names of a file with control characters escaped") {
  const std::string file = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\ng \x1b[31mred" + std::string(1000, 'x') + "\n";
  const Mesh mesh = read_text_mesh("a.obj", file);
  REQUIRE(mesh.notes.size() == 1);
  CHECK(mesh.notes[0].find("\\u001b[31mred") != std::string::npos);
  CHECK(mesh.notes[0].size() < 200);
}

std::string grid(std::string_view dimensions, const std::string& behind = "") {
  return fmt::format(
      "# vtk DataFile Version 3.0\nt\nASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS {}\nORIGIN 0 0 0\nSPACING 1 1 1\n{}",
      dimensions, behind);
}

TEST_CASE("a grid has a million points, or one for each byte of its file") {
  for (const char* dimensions : {"256 256 256", "1000001 1 1", "1 1 1000001", "2 500001 1", "4294967296 4294967296 1",
                                 "18446744073709551615 18446744073709551615 18446744073709551615"}) {
    CAPTURE(dimensions);
    CHECK(error_of("a.vtk", grid(dimensions)).find("a.vtk:5: ") != std::string::npos);
  }
  CHECK(has_facts(error_of("a.vtk", grid("256 256 256")), "a.vtk:5: | 256 x 256 x 256 | 1000000 points | 111 bytes"));
  CHECK(read_text_mesh("a.vtk", grid("1000000 1 1")).cell_count() == 999'999);
  std::string data = "CELL_DATA 1000001\nSCALARS a int\nLOOKUP_TABLE default\n";
  for (int k = 0; k < 1'000'001; ++k) data += "7 ";
  CHECK(read_text_mesh("a.vtk", grid("1000002 1 1", data)).cell_count() == 1'000'001);
}

TEST_CASE("files of more than 4 GiB are refused before they are read") {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "a.stl";
  folder.write("a.stl", "solid\n");
  std::filesystem::resize_file(file, (std::uintmax_t{4} << 30U) + 1);  // takes no room on the disk
  CHECK_THROWS_WITH_AS(static_cast<void>(read_mesh(file)), doctest::Contains("larger than 4 GiB"), Error);
}

TEST_CASE("empty blocks of an entity cost the same however many groups it has") {
  constexpr int many = 100'000;
  std::string file = fmt::format("$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Entities\n0 0 1 0\n1 0 0 0 0 0 0 {}", many);
  for (int k = 1; k <= many; ++k) file += fmt::format(" {}", k);
  file += " 0\n$EndEntities\n$Nodes\n1 3 1 3\n2 1 0 3\n1\n2\n3\n0 0 0\n1 0 0\n0 1 0\n$EndNodes\n";
  file += fmt::format("$Elements\n{} 1 1 1\n", many);
  for (int k = 1; k < many; ++k) file += "2 1 2 0\n";
  file += "2 1 2 1\n1 1 2 3\n$EndElements\n";
  const std::clock_t begin = std::clock();
  CHECK(read_text_mesh("a.msh", file).groups.size() == many);
  // Of the processor's time, for the slowest machine: a fifth of a second; all blocks in all groups take a minute.
  CHECK(static_cast<double>(std::clock() - begin) < 10.0 * CLOCKS_PER_SEC);
}

TEST_CASE("more components than the file has bytes for") {
  const std::string head = vtk_legacy_samples()[0].bytes + "FIELD f 1\n";
  CHECK(error_of("a.vtk", head + "a 4611686018427387904 4 float\n1 2 3 4\n").find("the number of components is") !=
        std::string::npos);
}

}  // namespace
}  // namespace springnet::testing
