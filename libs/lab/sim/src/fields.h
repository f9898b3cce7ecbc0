#pragma once
#include <talus/sim/geometry.h>
#include <yaml-cpp/yaml.h>

#include <limits>
#include <string>
#include <vector>

namespace talus::sim
{
/** What a number may be. */
struct Range
{
  double min, max;
};
constexpr Range kAny{-1e6, 1e6};
constexpr Range kPositive{1e-6, 1e6};
constexpr Range kNotNegative{0, 1e6};
constexpr Range kShare{0, 1};

/** One map of a world file with the keys that it may have. Everything that is wrong becomes a
 * std::runtime_error "FILE:LINE: WHERE: ...". */
class Fields
{
 public:
  /** Checks that `node` is a map, holds each key once and none but the words of `known`. `where`
   * names the map in messages, e.g. "objects.box". */
  Fields(
      const YAML::Node& node, const std::string& file, const std::string& where,
      const std::string& known);

  bool has(const std::string& key) const;
  /** The node of a key that must be there. */
  YAML::Node node(const std::string& key) const;

  double number(const std::string& key, Range range) const;
  double number_or(const std::string& key, double fallback, Range range) const;
  int whole(const std::string& key, int min, int max) const;
  int whole_or(const std::string& key, int fallback, int min, int max) const;
  bool flag_or(const std::string& key, bool fallback) const;
  std::string text_or(const std::string& key, const std::string& fallback) const;
  /** A list of exactly `count` numbers. */
  std::vector<double> numbers(const std::string& key, std::size_t count, Range range) const;
  Vec3 vector(const std::string& key, Range range) const;
  std::vector<double> numbers_or(
      const std::string& key, const std::vector<double>& fallback, Range range) const;
  /** A list of lists of exactly `count` numbers, one or more. */
  std::vector<std::vector<double>> rows(const std::string& key, std::size_t count) const;

  /** Throws with the line of `node`. */
  [[noreturn]] void fail(const YAML::Node& node, const std::string& what) const;
  [[noreturn]] void fail(const std::string& key, const std::string& what) const;

  const std::string& file() const { return file_; }
  const std::string& where() const { return where_; }

 private:
  double to_number(const YAML::Node& node, const std::string& key, Range range) const;
  std::vector<double> to_numbers(
      const YAML::Node& node, const std::string& key, std::size_t count, Range range) const;

  YAML::Node node_;
  std::string file_, where_;
};

/** ", did you mean 'box'? Known: box, post" of a word that is none of them. */
std::string known_words(const std::string& word, const std::vector<std::string>& known);

/** An entry of a list such as `- box: {...}`: its one key, which must be one of `known`. */
std::string only_key(
    const YAML::Node& node, const std::string& file, const std::string& where,
    const std::vector<std::string>& known);

/** Throws for what is no list, with an example of its entries, and for one of more than 1000. */
void require_list(
    const YAML::Node& list, const std::string& file, const std::string& where,
    const std::string& example);

/** Throws for a list that is longer: each entry costs time in every ray, and short names can repeat
 * long ones. */
void require_max_size(
    const YAML::Node& list, const std::string& file, const std::string& where,
    std::size_t max_size);

/** "FILE:LINE: WHERE: WHAT" */
[[noreturn]] void fail_at(
    const YAML::Node& node, const std::string& file, const std::string& where,
    const std::string& what);

}  // namespace talus::sim
