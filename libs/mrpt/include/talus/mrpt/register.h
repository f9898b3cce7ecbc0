#pragma once

namespace talus
{
/** Makes the MRPT classes of this library known by name, for INI files and serialization. Programs
 * that link the library call it once at start: it also makes their copy of the classes the one that
 * counts when the plugin has been preloaded. Calling it again does no harm. */
void register_mrpt_classes();

}  // namespace talus
