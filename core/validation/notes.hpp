// What a reader of a validation should know about its numbers, in sentences.
#pragma once

#include <springnet/validation.hpp>

namespace springnet {

// Appends to Validation::notes, from all else that is in it.
void write_notes(const RecordTimes& records, Validation& validation);

}  // namespace springnet
