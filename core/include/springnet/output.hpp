// All that writes files: runs, and the writers for programs that simulate on their own.
#pragma once

#include <springnet/run.hpp>
#include <springnet/tables.hpp>
#include <springnet/vtk.hpp>
