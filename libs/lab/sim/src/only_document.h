#pragma once
#include <yaml-cpp/yaml.h>

#include <string>

namespace talus::sim
{
/** The document of a YAML text. Throws YAML::Exception for what is no YAML, and std::runtime_error
 * for a second document: a file holds one world. */
YAML::Node only_document(const std::string& text, const std::string& file);

}  // namespace talus::sim
