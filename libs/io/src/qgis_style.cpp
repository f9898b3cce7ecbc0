#include <talus/io/atomic_file.h>
#include <talus/io/map_picture.h>
#include <talus/io/palette.h>
#include <talus/number_text.h>

#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>

namespace talus::io
{
namespace
{
constexpr int kSteps = 10;

std::string hex(const Rgb& c)
{
  std::array<char, 8> text{};
  std::snprintf(text.data(), text.size(), "#%02x%02x%02x", c[0], c[1], c[2]);
  return text.data();
}

/** Colours between 0, blocked, and 1, free. */
std::string colour_items()
{
  std::string items;
  for (int k = 0; k <= kSteps; ++k)
  {
    const double t = static_cast<double>(k) / kSteps;
    const std::string word = k == 0        ? palette::kBlocked.name
                             : k == kSteps ? palette::kFree.name
                                           : "";
    items += "          <item alpha=\"255\" value=\"" + number_text(t) + "\" label=\"" +
             number_text(t) + " " + word + "\" color=\"" +
             hex(score_colour(static_cast<float>(t))) + "\"/>\n";
  }
  return items;
}

std::string style_text()
{
  return "<!DOCTYPE qgis PUBLIC 'http://mrcc.com/qgis.dtd' 'SYSTEM'>\n"
         "<qgis version=\"3.22\" styleCategories=\"Symbology\">\n"
         "  <pipe>\n"
         "    <rasterrenderer type=\"singlebandpseudocolor\" band=\"1\" opacity=\"1\" "
         "alphaBand=\"-1\" classificationMin=\"0\" classificationMax=\"1\">\n"
         "      <rastershader>\n"
         "        <colorrampshader colorRampType=\"INTERPOLATED\" classificationMode=\"1\" "
         "clip=\"0\">\n" +
         colour_items() +
         "        </colorrampshader>\n"
         "      </rastershader>\n"
         "    </rasterrenderer>\n"
         "    <rasterresampler/>\n"
         "  </pipe>\n"
         "  <blendMode>0</blendMode>\n"
         "</qgis>\n";
}
}  // namespace

void write_qgis_style(const std::string& path) { write_file(path, style_text()); }

bool is_users_qgis_style(const std::string& path)
{
  std::ifstream file(path, std::ios::binary);
  if (!file && !std::filesystem::exists(path)) return false;
  std::ostringstream text;
  text << file.rdbuf();
  if (!file) throw std::runtime_error(path + ": cannot be read");
  return text.str() != style_text();
}

}  // namespace talus::io
