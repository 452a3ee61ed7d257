// ParamInfo holds what is known of a parameter of a scene: the row that the parser checks against, warnings
// quote, and the manual (`cuticle features`) prints.
#pragma once

#include <limits>
#include <span>
#include <string_view>

namespace cuticle {

// One parameter of a plug-in or of a fiber model. Texts live as long as the program.
struct ParamInfo {
    std::string_view name; // as a scene writes it
    // "float", "integer", "bool", "string", "point3", "spectrum", "texture name", ...; "float texture" and
    // "spectrum texture" take a value or a texture of that kind.
    std::string_view type;
    std::string_view unit; // "degrees", "1/radius", "lengths of the scene"; "" for a pure number
    std::string_view
        defaultValue;         // as a scene would write it, "0.3"; or in words, "from beta_m"; "" for none
    std::string_view meaning; // one line, with its source (paper and equation) where it has one
    // The values that a number may have; beyond them it is refused, or taken as the nearest with a warning:
    // the maker says which. Both infinite: any.
    double low = -std::numeric_limits<double>::infinity(), high = std::numeric_limits<double>::infinity();
    std::span<const std::string_view> choices =
        {}; // of a string: the names that it may be, the default first
};

// The row of a string that is one of `choices`. defaultValue "": the first of them.
constexpr ParamInfo ChoiceParam(std::string_view name, std::span<const std::string_view> choices,
                                std::string_view meaning, std::string_view defaultValue = "") {
    ParamInfo info{name, "string", "", defaultValue, meaning};
    info.choices = choices;
    if (defaultValue.empty() && !choices.empty())
        info.defaultValue = choices.front();
    return info;
}

} // namespace cuticle
