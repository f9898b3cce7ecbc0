#include <mrpt/config/CConfigFileBase.h>
#include <mrpt/maps/TMetricMapTypesRegistry.h>
#include <mrpt/serialization/CArchive.h>
#include <mrpt/system/string_utils.h>
#include <talus/hints/hint_finder.h>
#include <talus/mrpt/CDualElevationMap.h>
#include <talus/mrpt/CObservationTraversability.h>
#include <talus/mrpt/parameters_ini.h>
#include <talus/number_text.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <stdexcept>
#include <utility>

#include "ini_sections.h"
#include "warn_once.h"
#include "whole_map.h"

namespace
{
using Registry = mrpt::maps::internal::TMetricMapTypesRegistry;

/** `terrain` is the name of INI files. It must differ from the class name by more than case: MRPT
 * also registers the bare class name and ignores case, so that one entry would make two maps. */
constexpr const char* kNames = "talus::CDualElevationMap,terrain";

/** Nothing when a copy of the class is registered already (a program that links it and loads the
 * plugin): the first copy stays, so that all maps of a process are of one class. */
const char* names_unless_registered()
{
  return Registry::Instance().getAllRegistered().count("talus::CDualElevationMap") ? "" : kNames;
}

/** A map whose other sections are there: of one without any load_parameters() warns. */
void warn_without_creation(const mrpt::config::CConfigFileBase& source, const std::string& prefix)
{
  const auto& endings = talus::detail::section_endings();
  const bool any = std::any_of(
      endings.begin(), endings.end(),
      [&](const auto& e) { return source.sectionExists(prefix + e); });
  if (any && !source.sectionExists(prefix + "_creationOpts"))
    talus::detail::warn_once(
        "no section [" + prefix +
        "_creationOpts]: what belongs there (resolution, window, backend, threads, device, "
        "keep_whole) "
        "keeps its default");
}

/** Sections `APP_NAME_07_...` where there are fewer maps of that name. */
void warn_numbers(
    const mrpt::config::CConfigFileBase& source, const std::string& app, const std::string& name)
{
  const int count = source.read_int(app, name + "_count", 0);
  if (count <= 0) return;
  const std::string begin = mrpt::system::lowerCase(app + "_" + name + "_");
  std::vector<std::string> sections;
  source.getAllSections(sections);
  for (const auto& s : sections)
  {
    if (mrpt::system::lowerCase(s).rfind(begin, 0) != 0) continue;
    char* end = nullptr;
    const char* digits = s.c_str() + begin.size();
    const unsigned long number = std::strtoul(digits, &end, 10);
    if (std::isdigit(static_cast<unsigned char>(*digits)) && *end == '_' &&
        number >= static_cast<unsigned long>(count))
      talus::detail::warn_once(
          "section [" + s + "] is not read: [" + app + "] has " + name +
          mrpt::format("_count = %d, and the first map is number 00", count));
  }
}

void warn_names(const mrpt::config::CConfigFileBase& source, const std::string& app)
{
  std::string names;
  int used = 0;
  for (const char* key :
       {"terrain_count", "CDualElevationMap_count", "talus::CDualElevationMap_count"})
    if (source.read_int(app, key, 0) > 0) names += std::string(used++ ? " and " : "") + key;
  if (used > 1)
    talus::detail::warn_once(
        "[" + app + "] has " + names + ": each makes maps of its own; leave one of them");
}

/** What a person should know about the sections of one map: `APP_terrain_00`. */
void warn_sections(const mrpt::config::CConfigFileBase& source, const std::string& prefix)
{
  warn_without_creation(source, prefix);
  const auto number = prefix.rfind('_');
  const auto name = number == std::string::npos ? number : prefix.rfind('_', number - 1);
  if (name == std::string::npos) return;
  const std::string app = prefix.substr(0, name);
  warn_numbers(source, app, prefix.substr(name + 1, number - name - 1));
  warn_names(source, app);
}
}  // namespace

//  =========== Begin of Map definition ============
MAP_DEFINITION_REGISTER(names_unless_registered(), talus::CDualElevationMap)

talus::CDualElevationMap::TMapDefinition::TMapDefinition() = default;

void talus::CDualElevationMap::TMapDefinition::loadFromConfigFile_map_specific(
    const mrpt::config::CConfigFileBase& source, const std::string& sectionNamePrefix)
{
  warn_sections(source, sectionNamePrefix);
  for (const auto& w : load_parameters(source, sectionNamePrefix, insertionOpts))
    detail::warn_once(w);
  resolution.reset();
  window.reset();
  load_execution(source, sectionNamePrefix, backend, threads, device);
  keepWhole =
      detail::ini_flag(source, sectionNamePrefix + "_creationOpts", "keep_whole", keepWhole);
  place = detail::in_section(source, sectionNamePrefix + "_creationOpts");
  likelihoodOpts.loadFromConfigFile(source, sectionNamePrefix + "_likelihoodOpts");
  renderOpts.loadFromConfigFile(source, sectionNamePrefix + "_renderOpts");
}

void talus::CDualElevationMap::TMapDefinition::dumpToTextStream_map_specific(
    std::ostream& out) const
{
  out << "resolution = " << number_text(resolution.value_or(insertionOpts.resolution_m)) << " m\n"
      << "window     = " << number_text(window.value_or(insertionOpts.window_m)) << " m\n"
      << "backend    = " << backend_text(backend) << "\n"
      << "threads    = " << std::to_string(threads) << "\n"
      << "device     = " << std::to_string(device) << "\n"
      << "keep_whole = " << (keepWhole ? "true" : "false") << "\n";
  insertionOpts.dumpToTextStream(out);
  likelihoodOpts.dumpToTextStream(out);
  renderOpts.dumpToTextStream(out);
}

namespace
{
/** An absent device is reported now, not at the first scan. */
void make_mapper_now(talus::CDualElevationMap& map, const std::string& place)
{
  try
  {
    map.mapper();
  }
  catch (const std::runtime_error& e)
  {
    throw std::runtime_error(e.what() + place);
  }
}
}  // namespace

// A pointer or a shared pointer, as this version of MRPT wants it.
mrpt::maps::internal::MapCtorFromDefFunctor::result_type
talus::CDualElevationMap::internal_CreateFromMapDefinition(
    const mrpt::maps::TMetricMapInitializer& d)
{
  const auto& def = dynamic_cast<const TMapDefinition&>(d);
  Parameters p = def.insertionOpts;
  p.resolution_m = def.resolution.value_or(p.resolution_m);
  p.window_m = def.window.value_or(p.window_m);

  auto map =
      std::make_unique<CDualElevationMap>(p, def.backend, def.threads, def.keepWhole, def.device);
  map->likelihoodOptions = def.likelihoodOpts;
  map->renderOptions = def.renderOpts;
  if (def.backend == Backend::Cuda) make_mapper_now(*map, def.place);
  return mrpt::maps::internal::MapCtorFromDefFunctor::result_type(map.release());
}
//  =========== End of Map definition Block =========

IMPLEMENTS_SERIALIZABLE(CDualElevationMap, CMetricMap, talus)

// By name, for the copies and files of whatever program has this unit in it; the first copy stays.
// A variable, so that it comes after the class's own: MRPT_INITIALIZER may run before.
[[maybe_unused]] static const bool dual_elevation_map_is_known = []
{
  if (!mrpt::rtti::findRegisteredClass("talus::CDualElevationMap", false))
    mrpt::rtti::registerClass(CLASS_ID_NAMESPACE(CDualElevationMap, talus));
  return true;
}();

namespace talus
{
using mrpt::maps::CMetricMap;

void register_mrpt_classes()
{
  Registry::Instance().doRegister(
      kNames, &CDualElevationMap::MapDefinition,
      &CDualElevationMap::internal_CreateFromMapDefinition);
  mrpt::rtti::registerClass(CLASS_ID_NAMESPACE(CDualElevationMap, talus));
  mrpt::rtti::registerClass(CLASS_ID_NAMESPACE(CObservationTraversability, talus));
}

CDualElevationMap::CDualElevationMap(
    const Parameters& parameters, Backend backend, int threads, bool keep_whole, int device)
    : m_backend(backend), m_threads(threads), m_device(device), m_keep_whole(keep_whole)
{
  parameters.validate();
  static_cast<Parameters&>(insertionOptions) = parameters;
}

CDualElevationMap::CDualElevationMap(const CDualElevationMap& o) : CMetricMap(o) { *this = o; }

CDualElevationMap& CDualElevationMap::operator=(const CDualElevationMap& o)
{
  if (this == &o) return *this;
  CMetricMap::operator=(o);
  takeSettings(o);
  m_device = o.m_device;
  m_lastReport = o.m_lastReport;
  m_hints.reset();
  forgetDerived();
  m_mapper.reset();
  m_whole = o.m_whole ? std::make_unique<WholeMap>(*o.m_whole) : nullptr;
  if (!o.m_mapper || o.isEmpty()) return *this;
  m_mapper = std::make_unique<ElevationMapper>(
      o.m_mapper->parameters(), o.m_mapper->save(), m_backend, m_threads, m_device);
  return *this;
}

/** What a stream has, too, besides what was mapped. */
void CDualElevationMap::takeSettings(const CDualElevationMap& o)
{
  genericMapParams = o.genericMapParams;
  insertionOptions = o.insertionOptions;
  likelihoodOptions = o.likelihoodOptions;
  renderOptions = o.renderOptions;
  m_backend = o.m_backend;
  m_threads = o.m_threads;
  m_keep_whole = o.m_keep_whole;
  m_T_map_base = o.m_T_map_base;
  m_sensors = o.m_sensors;
}

CDualElevationMap::~CDualElevationMap() = default;

ElevationMapper& CDualElevationMap::mapper()
{
  forgetDerived();
  return const_cast<ElevationMapper&>(std::as_const(*this).mapper());
}

const ElevationMapper& CDualElevationMap::mapper() const
{
  if (!m_mapper)
    m_mapper = std::make_unique<ElevationMapper>(insertionOptions, m_backend, m_threads, m_device);
  return *m_mapper;
}

WholeMap& CDualElevationMap::whole() const
{
  if (!m_whole) m_whole = std::make_unique<WholeMap>(mapper().parameters().resolution_m);
  return *m_whole;
}

MapView CDualElevationMap::view() const
{
  if (!m_whole) return mapper();
  const MapSnapshot& floor = whole().floor(mapper());
  if (floor.window.cells == 0) return mapper();  // nothing was seen yet
  return floor;
}

void CDualElevationMap::loadSite(const std::string& path)
{
  if (!m_keep_whole)
    throw std::logic_error(
        "CDualElevationMap::loadSite: this map keeps no more than its window: keep_whole = true");
  if (!isEmpty())
    throw std::logic_error("CDualElevationMap::loadSite: before the first observation");
  whole().load(path);
}

void CDualElevationMap::forgetDerived()
{
  if (m_whole) m_whole->forget_floor();
  m_pointsCache.reset();
  m_standingCache.reset();
  m_sceneCache.clear();
}

bool CDualElevationMap::isEmpty() const
{
  return (!m_mapper || m_mapper->empty()) && !(m_whole && m_whole->is_loaded());
}

void CDualElevationMap::internal_clear()
{
  if (m_mapper) m_mapper->clear();
  m_whole.reset();
  forgetDerived();
  m_T_map_base = {};
  m_sensors = {};
  m_lastReport = {};
  m_hints.reset();
}

std::string CDualElevationMap::asString() const
{
  const Parameters& p = m_mapper ? m_mapper->parameters() : insertionOptions;
  const std::string side = number_text(p.window_m, 6) + " ";
  const std::string size = side + "x " + side + "m at " + number_text(p.resolution_m, 6) + " m";
  if (isEmpty()) return "talus::CDualElevationMap, " + size + ", empty";
  const MapView shown = view();
  const auto& ground = shown.layer(Layer::GroundElevation);
  const auto known = static_cast<std::size_t>(
      std::count_if(ground.begin(), ground.end(), [](float z) { return !std::isnan(z); }));
  const Window w = shown.window();
  return mrpt::format(
      "talus::CDualElevationMap, %s from (%s,%s), %zu of %zu cells with ground, backend %s",
      size.c_str(), fixed_text(w.min_x_m(), 2).c_str(), fixed_text(w.min_y_m(), 2).c_str(), known,
      ground.size(), m_mapper->backend_name().c_str());
}
}  // namespace talus
