// All plug-ins: the tables of this room and of those below it.
#pragma once

#include "parser/plugins.h"

namespace cuticle {

const PluginTable &SamplerPlugins();
const PluginTable &FilmPlugins();
const PluginTable &FilterPlugins();
const PluginTable &IntegratorPlugins();
const PluginTable &AcceleratorPlugins();

// Every kind's table: what ParseScene is handed by the program, and what `cuticle features` prints.
const PluginTables &AllPlugins();

} // namespace cuticle
