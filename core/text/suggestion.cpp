#include <algorithm>
#include <cctype>
#include <numeric>

#include <springnet/suggestion.hpp>

namespace springnet {
namespace {

std::string lower(std::string_view text) {
  std::string result(text);
  std::transform(result.begin(), result.end(), result.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return result;
}

// Insertions, deletions, replacements and swaps of neighbours that turn a into b (optimal string alignment).
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> before_last, last(b.size() + 1), row(b.size() + 1);
  std::iota(last.begin(), last.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      row[j] = std::min({last[j] + 1, row[j - 1] + 1, last[j - 1] + (a[i - 1] == b[j - 1] ? 0u : 1u)});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) {
        row[j] = std::min(row[j], before_last[j - 2] + 1);
      }
    }
    before_last = last;
    last = row;
  }
  return last.back();
}

// An abbreviation ("damp" for "damping") counts as one wrong letter. Values above `largest` are not computed exactly,
// to save time.
std::size_t distance(std::string_view a, std::string_view b, std::size_t largest) {
  constexpr std::size_t shortest_abbreviation = 3;
  const std::size_t common = std::min(a.size(), b.size());
  if (common >= shortest_abbreviation && a.substr(0, common) == b.substr(0, common))
    return a.size() == b.size() ? 0 : 1;
  if (std::max(a.size(), b.size()) - common > largest) return largest + 1;
  return edit_distance(a, b);
}

}  // namespace

std::string suggestion(std::string_view name, const std::vector<std::string>& known) {
  constexpr std::size_t max_shown = 3;
  // One wrong letter in three is a typing error; more is another word.
  const std::size_t largest = std::max<std::size_t>(1, name.size() / 3);
  const std::string wanted = lower(name);
  std::size_t best = largest + 1;
  std::vector<std::string> nearest;
  for (const std::string& candidate : known) {
    // Names of one letter never resemble each other.
    if (candidate.size() < 2 && wanted != lower(candidate)) continue;
    const std::size_t d = distance(wanted, lower(candidate), largest);
    if (d >= std::max(wanted.size(), candidate.size())) continue;
    if (d < best) {
      best = d;
      nearest.clear();
    }
    if (d == best && d <= largest && std::find(nearest.begin(), nearest.end(), candidate) == nearest.end()) {
      nearest.push_back(candidate);
    }
  }
  if (nearest.empty()) return {};
  std::sort(nearest.begin(), nearest.end());
  if (nearest.size() > max_shown) nearest.resize(max_shown);
  std::string text = "did you mean '" + nearest.front() + "'";
  for (std::size_t i = 1; i < nearest.size(); ++i) {
    text += (i + 1 == nearest.size() ? " or '" : ", '") + nearest[i] + "'";
  }
  return text + "?";
}

}  // namespace springnet
