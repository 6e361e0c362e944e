// The part of a mesh target that depends on its format.
extern const char* const mesh_file;
const char* const mesh_file = "mesh" ENDING;
