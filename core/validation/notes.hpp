// Notes about the numbers of a validation.
#pragma once

#include <springnet/validation.hpp>

namespace springnet {

// Appends to Validation::notes. Call it last: the notes follow from everything else in the validation.
void write_notes(const RecordTimes& records, Validation& validation);

}  // namespace springnet
