#include "scene.h"

talus::Backend talus::test::tested_backend() { return Backend::Cpu; }
