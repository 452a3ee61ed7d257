// The tables of the plug-ins that this room makes, and of the media, which nobody makes yet.
#pragma once

#include "parser/plugins.h"

namespace cuticle {

const PluginTable &CameraPlugins();    // in camera.cpp
const PluginTable &ShapePlugins();     // in shape_makers.cpp
const PluginTable &LightPlugins();     // in light.cpp
const PluginTable &AreaLightPlugins(); // in light.cpp
const PluginTable &MediumPlugins();    // in plugins.cpp

} // namespace cuticle
