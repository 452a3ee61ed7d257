// Files of statements in the scene language's syntax, such as recipes of simulations:
//
//     Directive "name" "type parameter" value ...
//
// Which directives, names and parameters there are, tables say, which are the manual too. Unlike a scene's,
// statements are ours alone: whatever a table does not have is an Error.
#pragma once

#include "parser/param_set.h"
#include "parser/plugins.h"

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace cuticle {

// A directive, and the names that it takes. Of a parameter's ParamInfo the type is "float", "integer",
// "bool", "string", "point3", "vector3", "spectrum", or one of these with an s for any number of them; all
// numbers lie in its range, and a string is one of its choices if it has any.
struct StatementKind {
    std::string_view directive;
    std::vector<PluginInfo> rows;
    bool many = false; // may stand in a file more than once
};

struct Statement {
    const StatementKind *kind;
    const PluginInfo *row;
    ParamSet params; // of the row's types and ranges
};

// Reads a file. Throws Error with file:line:col for text that is no statement, for names that the tables do
// not have, for values out of range and of another type, and for a directive that stands there again.
std::vector<Statement> ReadStatements(std::span<const StatementKind> kinds, const std::string &filename);
// The same from text; `name` stands in messages, relative names of files are taken from `folder`.
std::vector<Statement> ParseStatements(std::span<const StatementKind> kinds, const std::string &text,
                                       const std::string &name, const std::string &folder = ".");

// All directives with their names and parameters, in Markdown.
std::string StatementManual(std::span<const StatementKind> kinds);

} // namespace cuticle
