#include <cstdio>
#include <filesystem>
#include <memory>
#include <system_error>

#include <fmt/format.h>
#include <springnet/printable.hpp>
#include <springnet/records.hpp>

#include "commands.hpp"
#include "common.hpp"
#include "text/counted.hpp"

namespace springnet::tool {

namespace {

constexpr const char* convert_examples = R"(Examples (the first two lines create the file):
  springnet new --example cube
  springnet run cube/cube.toml -o results/table --set 'output.format="binary"'
  springnet convert results/table/trajectory.bin            writes results/table/trajectory.csv
  springnet convert results/table/trajectory.bin -o positions.csv

Exit status:
  0 done   1 the text cannot be written   2 usage, or no such file)";

struct ConvertArguments {
  std::filesystem::path file;
  std::filesystem::path output;
  bool quiet = false;
};

int convert(const ConvertArguments& arguments) {
  RecordReader records(arguments.file);
  std::filesystem::path text = arguments.output;
  const bool named = !text.empty();
  if (!named) text = std::filesystem::path(arguments.file).replace_extension(".csv");
  std::error_code unknown;
  if (std::filesystem::equivalent(text, arguments.file, unknown)) {
    throw Error(ErrorKind::input,
                fmt::format("{}: is the input file; choose another output file with -o", text.string()));
  }
  // Only a file that the user names may be a link, a pipe or a device.
  write_csv(records, named ? OutputFile(text) : OutputFile(OutputFolder::containing(text), text.filename().string()));
  if (!arguments.quiet) {
    fmt::print("{}: {} of {}\n", printable_message(text.string()), counted(records.records(), "record"),
               counted(records.rows().size(), "row"));
  }
  return done;
}

}  // namespace

void add_convert(CLI::App& app, Action& action) {
  const auto arguments = std::make_shared<ConvertArguments>();
  CLI::App* const command = app.add_subcommand("convert", "Convert a binary table of a run to text");
  command->add_option("FILE", arguments->file, "A .bin file that a run with output.format = \"binary\" wrote")
      ->type_name("")
      ->required();
  command->add_option("-o,--output", arguments->output, "File to write [the same name with .csv]")->type_name("FILE");
  command->add_flag("-q,--quiet", arguments->quiet, "Print only errors");
  command->footer(convert_examples);
  command->callback([arguments, &action] { action = [arguments] { return convert(*arguments); }; });
}

}  // namespace springnet::tool
