// The file `checkpoint` of a run: the simulation and the outputs at the end of a time step, from which a run goes on
// that was stopped, killed or ran out of room.
#pragma once

#include <string>
#include <string_view>

#include <springnet/output_folder.hpp>
#include <springnet/run.hpp>

#include "text/identity.hpp"

namespace springnet {

// What must be the same where a run resumes, besides what Simulation::restore() compares.
[[nodiscard]] Identity identity_of(const Scene& scene);

// Writes what the files of the folder have to the disk, then the checkpoint, which takes the place of the one before.
// Throws OutputError; the one before then stays.
void write_checkpoint(const OutputFolder::Pointer& folder, const Identity& identity, std::string_view content);

// The content. Throws Error(input) if there is none, it is damaged, or of another run.
[[nodiscard]] std::string read_checkpoint(const OutputFolder::Pointer& folder, const Identity& identity);

// Bytes, about: of the one before and the next one.
[[nodiscard]] double checkpoint_bytes(const Scene& scene);

}  // namespace springnet
