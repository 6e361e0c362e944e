// Foreign text for a terminal.
#include <string>

#include <doctest/doctest.h>

#include <springnet/printable.hpp>

using namespace springnet;

TEST_CASE("printable text is unchanged") {
  CHECK(printable("") == "");
  CHECK(printable("left wall\\of [a.b] 'c' \"d\"") == "left wall\\of [a.b] 'c' \"d\"");
  CHECK(printable("Blase – größer, 膀胱, 🫧") == "Blase – größer, 膀胱, 🫧");
}

TEST_CASE("control characters are escaped") {
  CHECK(printable("\x1b[31mred\a\n\t") == "\\u001b[31mred\\u0007\\u000a\\u0009");
  CHECK(printable(std::string_view("a\0b", 3)) == "a\\u0000b");
  CHECK(printable("\x7f\xc2\x9b") == "\\u007f\\u009b");  // C1: the one-byte CSI
  CHECK(printable("a\xe2\x80\xae"
                  "txt.exe") == "a\\u202etxt.exe");  // right to left
  CHECK(printable("\xef\xbb\xbf"
                  "a\xf3\xa0\x80\xa1") == "\\ufeffa\\ue0021");  // mark of byte order, a tag
}

TEST_CASE("bytes that are not UTF-8 are escaped") {
  CHECK(printable("a\xff"
                  "b\x80") == "a\\xffb\\x80");
  CHECK(printable("\xc0\xaf") == "\\xc0\\xaf");  // overlong
  CHECK(printable("\xe0\x80\xaf") == "\\xe0\\x80\\xaf");
  CHECK(printable("\xed\xa0\x80") == "\\xed\\xa0\\x80");           // half a surrogate
  CHECK(printable("\xf4\x90\x80\x80") == "\\xf4\\x90\\x80\\x80");  // beyond Unicode
  CHECK(printable("\xe2\x82") == "\\xe2\\x82");                    // cut short
}

TEST_CASE("a long text is truncated, with its length") {
  CHECK(printable("abcdef", 6) == "abcdef");
  CHECK(printable("abcdefg", 6) == "abcdef… (7 characters)");
  CHECK(printable("ääää", 3) == "äää… (4 characters)");
  CHECK(printable(std::string(1'234'567, 'x')) == std::string(60, 'x') + "… (1,234,567 characters)");
  CHECK(printable(std::string(100, '\x1b'), 2) == "\\u001b\\u001b… (100 characters)");
}

TEST_CASE("a message keeps its lines, whole") {
  CHECK(printable_message("a\n\tb\x1b[2J\r\n") == "a\n\tb\\u001b[2J\\u000d\n");
  const std::string long_message(10'000, 'x');
  CHECK(printable_message(long_message) == long_message);
}
