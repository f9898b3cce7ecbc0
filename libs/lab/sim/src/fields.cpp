#include "fields.h"
#include <talus/number_text.h>
#include <talus/parameters.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>
#include <sstream>
#include <stdexcept>

namespace talus::sim
{
namespace
{
std::string list_of(const std::vector<std::string>& words)
{
  std::string out;
  for (const auto& w : words) out += (out.empty() ? "" : ", ") + w;
  return out;
}

std::string unknown_key(const std::string& key, const std::vector<std::string>& known)
{
  if (key.rfind("goal", 0) == 0)
    return "unknown key '" + key +
           "': a world has no goal; where a robot shall drive says `talus-nav WORLD.yaml --goal "
           "X,Y`, and where a recorded drive leads says `path_m` of `robot`";
  return "unknown key '" + key + "'" + known_words(key, known);
}

/** For messages: its beginning. */
std::string text_of(const YAML::Node& node)
{
  constexpr std::size_t kMax = 80;
  std::ostringstream out;
  out << node;
  const std::string text = out.str();
  return text.size() > kMax ? text.substr(0, kMax) + "..." : text;
}

std::string key_text(const YAML::Node& key, const std::string& file, const std::string& where)
{
  if (!key.IsScalar()) fail_at(key, file, where, "a key must be a word, not a list or a map");
  return key.Scalar();
}

}  // namespace

void fail_at(
    const YAML::Node& node, const std::string& file, const std::string& where,
    const std::string& what)
{
  std::ostringstream msg;
  msg << file << ':' << std::max(1, node.Mark().line + 1) << ": " << where << ": " << what;
  throw std::runtime_error(msg.str());
}

void require_max_size(
    const YAML::Node& list, const std::string& file, const std::string& where, std::size_t max_size)
{
  if (list.size() > max_size)
    fail_at(
        list, file, where,
        "has " + std::to_string(list.size()) + " entries, the limit is " +
            std::to_string(max_size));
}

void require_list(
    const YAML::Node& list, const std::string& file, const std::string& where,
    const std::string& example)
{
  if (!list.IsSequence()) fail_at(list, file, where, "must be a list, e.g. `- " + example + "`");
  require_max_size(list, file, where, 1000);
}

std::string known_words(const std::string& word, const std::vector<std::string>& known)
{
  const std::string nearest = nearest_name(word, known);
  return (nearest.empty() ? "." : ", did you mean '" + nearest + "'?") +
         " Known: " + list_of(known);
}

std::string only_key(
    const YAML::Node& node, const std::string& file, const std::string& where,
    const std::vector<std::string>& known)
{
  if (!node.IsMap() || node.size() != 1)
    fail_at(
        node, file, where,
        "an entry must be one kind with its keys, e.g. `- " + known.front() +
            ": {...}`; known kinds: " + list_of(known));
  auto key = key_text(node.begin()->first, file, where);
  if (std::find(known.begin(), known.end(), key) == known.end())
    fail_at(node.begin()->first, file, where, unknown_key(key, known));
  return key;
}

Fields::Fields(
    const YAML::Node& node, const std::string& file, const std::string& where,
    const std::string& known_words)
    : node_(node), file_(file), where_(where)
{
  std::istringstream words(known_words);
  const std::vector<std::string> known{std::istream_iterator<std::string>(words), {}};
  if (!node.IsMap()) fail(node, "must be a map with the keys " + list_of(known));
  std::set<std::string> seen;
  for (const auto& entry : node)
  {
    const auto key = key_text(entry.first, file, where);
    if (std::find(known.begin(), known.end(), key) == known.end())
      fail(entry.first, unknown_key(key, known));
    if (!seen.insert(key).second) fail(entry.first, "key '" + key + "' is given twice");
  }
}

void Fields::fail(const YAML::Node& node, const std::string& what) const
{
  fail_at(node, file_, where_, what);
}
void Fields::fail(const std::string& key, const std::string& what) const
{
  fail_at(node_[key], file_, where_, "key '" + key + "' " + what);
}

bool Fields::has(const std::string& key) const { return node_[key].IsDefined(); }

YAML::Node Fields::node(const std::string& key) const
{
  if (!has(key)) fail(node_, "key '" + key + "' is missing");
  return node_[key];
}

double Fields::to_number(const YAML::Node& node, const std::string& key, Range range) const
{
  const auto value = node.IsScalar() ? number_from(node.Scalar()) : std::nullopt;
  if (!value || !std::isfinite(*value))
    fail(node, "key '" + key + "': '" + text_of(node) + "' is not a number");
  if (*value < range.min || *value > range.max)
    fail(
        node, "key '" + key + "': " + number_text(*value, 6) + " is not in [" +
                  number_text(range.min, 6) + ", " + number_text(range.max, 6) + "]");
  return *value;
}

double Fields::number(const std::string& key, Range range) const
{
  return to_number(node(key), key, range);
}
double Fields::number_or(const std::string& key, double fallback, Range range) const
{
  return has(key) ? number(key, range) : fallback;
}

int Fields::whole(const std::string& key, int min, int max) const
{
  const double value = number(key, {static_cast<double>(min), static_cast<double>(max)});
  if (value != std::floor(value)) fail(key, "must be a whole number");
  return static_cast<int>(value);
}
int Fields::whole_or(const std::string& key, int fallback, int min, int max) const
{
  return has(key) ? whole(key, min, max) : fallback;
}

bool Fields::flag_or(const std::string& key, bool fallback) const
{
  if (!has(key)) return fallback;
  bool value = false;
  if (!node_[key].IsScalar() || !YAML::convert<bool>::decode(node_[key], value))
    fail(key, "must be true or false");
  return value;
}

std::string Fields::text_or(const std::string& key, const std::string& fallback) const
{
  if (!has(key)) return fallback;
  if (!node_[key].IsScalar()) fail(key, "must be a text");
  return node_[key].as<std::string>();
}

std::vector<double> Fields::to_numbers(
    const YAML::Node& node, const std::string& key, std::size_t count, Range range) const
{
  if (!node.IsSequence() || node.size() != count)
    fail(
        node, "key '" + key + "': '" + text_of(node) + "' must be a list of " +
                  std::to_string(count) + " numbers");
  std::vector<double> out;
  for (const auto& n : node) out.push_back(to_number(n, key, range));
  return out;
}

std::vector<double> Fields::numbers(const std::string& key, std::size_t count, Range range) const
{
  return to_numbers(node(key), key, count, range);
}
Vec3 Fields::vector(const std::string& key, Range range) const
{
  const auto v = numbers(key, 3, range);
  return {v[0], v[1], v[2]};
}
std::vector<double> Fields::numbers_or(
    const std::string& key, const std::vector<double>& fallback, Range range) const
{
  return has(key) ? numbers(key, fallback.size(), range) : fallback;
}

std::vector<std::vector<double>> Fields::rows(const std::string& key, std::size_t count) const
{
  const YAML::Node list = node(key);
  if (!list.IsSequence() || list.size() == 0)
    fail(
        list, "key '" + key + "' must be a list of lists of " + std::to_string(count) + " numbers");
  std::vector<std::vector<double>> out;
  for (const auto& row : list) out.push_back(to_numbers(row, key, count, kAny));
  return out;
}

}  // namespace talus::sim
