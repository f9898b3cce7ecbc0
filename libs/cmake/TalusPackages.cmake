# Debian packages of what install() copies, by `cpack -G DEB` in the build (./dev package):
#   talus               commands with their manuals, and the configurations and worlds in /usr/share/talus
#   talus-live          the commands that talk to robots with ROS 2, where Cyclone DDS is there
#   talus-mrpt-plugin   libtalus-mrpt.so, where loadPluginModules("libtalus-mrpt.so") finds it
#   python3-talus       import talus, where the build has it
#   libtalus-dev        static libraries, headers, what find_package(talus) reads, examples
# For the Debian they are made on: its libraries are what they need.
set(codename)
if(EXISTS /etc/os-release)
  file(STRINGS /etc/os-release codename REGEX "^VERSION_CODENAME=")
  string(REPLACE "VERSION_CODENAME=" "" codename "${codename}")
endif()
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME talus)
# Whom a package names as its maintainer: who makes it, as Debian's own tools ask for it, else as git does.
set(maintainer "$ENV{DEBFULLNAME} <$ENV{DEBEMAIL}>")
if(NOT maintainer MATCHES "^[^<]+ <[^>]+@[^>]+>$")
  execute_process(COMMAND git log -1 "--format=%an <%ae>" WORKING_DIRECTORY "${PROJECT_SOURCE_DIR}"
    OUTPUT_VARIABLE maintainer OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
endif()
if(NOT maintainer MATCHES "^[^<]+ <[^>]+@[^>]+>$")
  set(maintainer "The talus authors <talus@localhost>")
endif()
set(CPACK_PACKAGE_CONTACT "${maintainer}")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_OUTPUT_FILE_PREFIX packages)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE "1~${codename}")
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_ALL commands plugin dev)
set(TALUS_PACKAGES talus talus-mrpt-plugin libtalus-dev)
if(NOT TALUS_WITH_MRPT)
  set(CPACK_COMPONENTS_ALL dev)
  set(TALUS_PACKAGES libtalus-dev)
elseif(TARGET talus_live)
  list(APPEND CPACK_COMPONENTS_ALL live)
  list(APPEND TALUS_PACKAGES talus-live)
endif()
if(TALUS_PYTHON_MODULE)
  list(APPEND CPACK_COMPONENTS_ALL python)
  list(APPEND TALUS_PACKAGES python3-talus)
endif()

set(CPACK_DEBIAN_COMMANDS_PACKAGE_NAME talus)
set(CPACK_DEBIAN_COMMANDS_PACKAGE_SECTION science)
set(CPACK_DEBIAN_COMMANDS_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_COMMANDS_PACKAGE_DEPENDS "fonts-dejavu-core, libjs-leaflet, python3:any")  # the letters of pictures
set(CPACK_DEBIAN_COMMANDS_PACKAGE_SUGGESTS "talus-mrpt-plugin, snakemake")
set(CPACK_COMPONENT_COMMANDS_DESCRIPTION "Maps of the terrain around ground robots, from rawlogs of MRPT: commands")
set(CPACK_DEBIAN_LIVE_PACKAGE_NAME talus-live)
set(CPACK_DEBIAN_LIVE_PACKAGE_SECTION science)
set(CPACK_DEBIAN_LIVE_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_LIVE_PACKAGE_DEPENDS "fonts-dejavu-core, libjs-leaflet")
set(CPACK_DEBIAN_LIVE_PACKAGE_SUGGESTS talus)
set(CPACK_COMPONENT_LIVE_DESCRIPTION "Maps of the terrain around ground robots, live from robots with ROS 2")
set(CPACK_DEBIAN_PLUGIN_PACKAGE_NAME talus-mrpt-plugin)
set(CPACK_DEBIAN_PLUGIN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PLUGIN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PLUGIN_PACKAGE_DEPENDS "fonts-dejavu-core")
set(CPACK_DEBIAN_PLUGIN_PACKAGE_SUGGESTS mrpt-apps)
set(CPACK_COMPONENT_PLUGIN_DESCRIPTION "Terrain map of talus for programs of MRPT")
set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-talus)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS "${TALUS_PYTHON_NEEDS}")
set(CPACK_DEBIAN_PYTHON_PACKAGE_SUGGESTS "python3-matplotlib, jupyter-notebook")
set(CPACK_COMPONENT_PYTHON_DESCRIPTION "Terrain maps for ground robots: module for Python")
set(CPACK_DEBIAN_DEV_PACKAGE_NAME libtalus-dev)
set(CPACK_DEBIAN_DEV_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEV_PACKAGE_DEPENDS "libtbb-dev")
if(TALUS_WITH_MRPT)
  string(APPEND CPACK_DEBIAN_DEV_PACKAGE_DEPENDS ", libmrpt-maps-dev, libgdal-dev, libopencv-dev, zlib1g-dev, "
    "libzstd-dev, libyaml-cpp-dev, libceres-dev, libfastcdr-dev, libsqlite3-dev, liblz4-dev, libisal-dev, libfreetype-dev, liboctomap-dev")
endif()
set(CPACK_DEBIAN_DEV_PACKAGE_SUGGESTS "libmrpt-nav-dev")
set(CPACK_COMPONENT_DEV_DESCRIPTION "Terrain maps for ground robots: libraries for C++")
# What Debian asks of each package: a licence, a changelog of the package and that of the project, compressed.
file(STRINGS "${PROJECT_SOURCE_DIR}/CHANGELOG.md" released LIMIT_COUNT 1 REGEX "^## \\[${PROJECT_VERSION}\\]")
string(REGEX REPLACE ".* - " "" released "${released}")
file(READ "${PROJECT_SOURCE_DIR}/LICENSE" licence)
string(REGEX REPLACE "^[^\n]*\n\n[^\n]*\n\n" "" licence "${licence}")
file(READ "${PROJECT_SOURCE_DIR}/libs/formats/src/page/leaflet_licence.txt" leaflet)
foreach(text licence leaflet)  # paragraphs as Debian has them
  string(REGEX REPLACE "\n\n" "\n.\n" ${text} "${${text}}")
  string(REGEX REPLACE "\n$" "" ${text} "${${text}}")
  string(REPLACE "\n" "\n " ${text} "${${text}}")
endforeach()
set(debian "${PROJECT_BINARY_DIR}/debian")
file(WRITE "${debian}/copyright" "Format: https://www.debian.org/doc/packaging-manuals/copyright-format/1.0/
Upstream-Name: talus\n\nFiles: *\nCopyright: 2026, the talus authors\nLicense: BSD-3-Clause\n ${licence}\n
Files: libs/formats/src/page/leaflet_licence.txt\nCopyright: 2010-2019, Vladimir Agafonkin\n 2010-2011, CloudMade
Comment: talus-export and talus-live put Leaflet, of libjs-leaflet, into their pages.
License: BSD-2-Clause\n ${leaflet}\n")
execute_process(COMMAND date -R -u -d "${released}" OUTPUT_VARIABLE date OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
file(WRITE "${debian}/changelog.Debian" "talus (${PROJECT_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE}) ${codename}; urgency=medium

  * Version ${PROJECT_VERSION}: changelog.gz says what it can do.\n\n -- ${maintainer}  ${date}\n")
configure_file("${PROJECT_SOURCE_DIR}/CHANGELOG.md" "${debian}/changelog" COPYONLY)
execute_process(COMMAND gzip -9nkf "${debian}/changelog.Debian" "${debian}/changelog" ERROR_QUIET)
foreach(component package IN ZIP_LISTS CPACK_COMPONENTS_ALL TALUS_PACKAGES)
  install(FILES "${debian}/copyright" "${debian}/changelog.Debian.gz" "${debian}/changelog.gz"
    DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${package} COMPONENT ${component})
endforeach()
file(WRITE "${debian}/triggers" "activate-noawait ldconfig\n")
set(CPACK_DEBIAN_PLUGIN_PACKAGE_CONTROL_EXTRA "${debian}/triggers")
file(WRITE "${debian}/overrides" "# CPack always adds this call.
talus-mrpt-plugin: maintscript-calls-ldconfig
# A plugin that programs load by its name; nothing is linked with it, so it has no version.
talus-mrpt-plugin: package-name-doesnt-match-sonames libtalus-mrpt
talus-mrpt-plugin: shared-library-lacks-version *\n")
if(TALUS_WITH_MRPT)
  install(FILES "${debian}/overrides" DESTINATION ${CMAKE_INSTALL_DATADIR}/lintian/overrides RENAME talus-mrpt-plugin
    COMPONENT plugin)
endif()
include(CPack)
