// The tables of the plug-ins that this room makes, and of the media, which nobody makes yet.
#pragma once

#include "parser/plugins.h"

namespace cuticle {

const PluginTable &CameraPlugins();
const PluginTable &ShapePlugins();
const PluginTable &LightPlugins();
const PluginTable &AreaLightPlugins();
const PluginTable &MediumPlugins();

} // namespace cuticle
