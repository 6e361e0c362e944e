# Puts the page together and writes it as C++: cmake -DPAGE=FOLDER -DSTYLE=a|b -DLIBRARIES=a|b -DPROGRAM=a|b
# -DOUTPUT=FILE -P embed.cmake
cmake_minimum_required(VERSION 3.25)

# Contents of the files one after the other. "</script" in a string of a program would end its element.
function(read_files result list)
  string(REPLACE "|" ";" files "${list}")
  set(all "")
  foreach(path IN LISTS files)
    file(READ ${path} text)
    string(REPLACE "</script" "<\\/script" text "${text}")
    string(APPEND all "${text}\n")
  endforeach()
  set(${result} "${all}" PARENT_SCOPE)
endfunction()

file(READ ${PAGE}/index.html page)
file(READ ${PAGE}/notices.txt notices)
read_files(style "${STYLE}")
read_files(libraries "${LIBRARIES}")
read_files(program "${PROGRAM}")
foreach(part notices style libraries program)
  string(REPLACE "@${part}@" "${${part}}" page "${page}")
endforeach()

set(marker "@data@")
string(FIND "${page}" "${marker}" place)
if(place EQUAL -1)
  message(FATAL_ERROR "${PAGE}/index.html has no ${marker}")
endif()
string(SUBSTRING "${page}" 0 ${place} before)
string(LENGTH "${marker}" length)
math(EXPR place "${place} + ${length}")
string(SUBSTRING "${page}" ${place} -1 after)

set(quote "springnet_page")
foreach(part before after)
  string(FIND "${${part}}" ")${quote}\"" inside)
  if(NOT inside EQUAL -1)
    message(FATAL_ERROR "the page has the end of a literal in it")
  endif()
endforeach()
file(WRITE ${OUTPUT} "#include \"view/page.hpp\"
namespace springnet::view {
const std::string_view before_data = R\"${quote}(${before})${quote}\";
const std::string_view after_data = R\"${quote}(${after})${quote}\";
}  // namespace springnet::view
")
