// The manual of a scene's directives, made from the tables of plug-ins, in Markdown.
#pragma once

#include "parser/plugins.h"

#include <string>
#include <string_view>

namespace cuticle {

// One row a kind: what is rendered, and what stands in for the rest.
std::string FeatureTable(const PluginTables &tables);

// The plug-ins of a kind, each with its parameters: type, unit, range, default and meaning. kind: the
// directive's name, in capitals or not. Error for one that there is not.
std::string PluginManual(const PluginTables &tables, std::string_view kind);
// The same of one plug-in. Error for a name that the kind has not.
std::string PluginManual(const PluginTables &tables, std::string_view kind, std::string_view name);
// The same of one that is handed in, under the name of its directive.
std::string PluginManual(std::string_view directive, const PluginInfo &plugin);

// The values that a parameter may have, "0 to 1", "2 or more" or its choices; "" where any.
std::string RangeInWords(const ParamInfo &param);

} // namespace cuticle
