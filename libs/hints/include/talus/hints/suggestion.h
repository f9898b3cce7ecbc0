#pragma once
#include <string>

namespace talus::hints
{
/** A parameter that suits a log, its value as set_parameter() reads it, and why: a few words with
 * the figures. */
struct Suggestion
{
  /** Of the parameter; text of the value; a few words. */
  std::string name, value, reason;
};

}  // namespace talus::hints
