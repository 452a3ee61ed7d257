//> Define the parameters of a groom
#include "grooms/groom_params.h"

#include "core/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <deque>
#include <sstream>
#include <vector>

namespace cuticle {

namespace {

constexpr std::array<std::string_view, 4> kKinds{"head", "fur-ball", "hair-cube", "ball"};

//> Tabulate the styles
// To add one: a row here; a new way to comb is a case of HeadSource::Grow (head_source.cpp).
constexpr HeadStyleInfo kStyles[] = {
    //> Hang hair from a parting, or let it stand off
    {"straight", "long, straight, parted", [](GroomParams *) {}},
    {"wavy", "long waves, parted",
     [](GroomParams *p) {
         p->length = 38;
         p->clump = 0.7f;
         p->wispClump = 0.7f;
         p->curlRadius = 0.55f;
         p->curlLength = 8;
         p->frizz = 0.06f;
         p->volume = 1.6f;
     },
     Comb::Part, 0.45f, 0.24f, 0, true},
    {"curly", "curls of a finger's width",
     [](GroomParams *p) {
         p->length = 30;
         p->lengthVariation = 0.3f;
         p->locks = 900;
         p->clump = 0.85f;
         p->wisps = 5000;
         p->wispClump = 0.8f;
         p->curlRadius = 0.7f;
         p->curlLength = 4.6f;
         p->frizz = 0.05f;
         p->flyaways = 0.035f;
         p->volume = 2.0f;
         p->level = 0.35f;
     },
     Comb::Part, 0.85f, 0.16f},
    {"afro", "tight coils that stand off on all sides",
     [](GroomParams *p) {
         p->strands = 80000;
         p->length = 8.5f;
         p->lengthVariation = 0.25f;
         p->clump = 0.3f;
         p->wisps = 12000;
         p->wispClump = 0.75f;
         p->curlRadius = 0.28f;
         p->curlLength = 1.4f;
         p->frizz = 0.12f;
         p->volume = 0;
         p->level = 0;
     },
     Comb::Out, 4, 0.012f},
    //<
    //> Cut it, wind it, plait it
    {"bob", "straight, cut at the chin, the ends turned in",
     [](GroomParams *p) {
         p->length = 25.5f;
         p->lengthVariation = 0.1f;
         p->clump = 0.35f;
         p->frizz = 0.03f;
         p->flyaways = 0.015f;
         p->volume = 1.5f;
         p->level = 0.96f;
         p->tip = 0.6f;
     },
     Comb::Part, 0.5f, 0.26f, 0.35f},
    {"bun", "drawn back and wound up",
     [](GroomParams *p) {
         p->strands = 80000;
         p->length = 17;
         p->clump = 0.95f;
         p->wispClump = 0.9f;
         p->frizz = 0.02f;
         p->flyaways = 0.02f;
         p->volume = 0.5f;
         p->level = 0;
     },
     Comb::Bun, 0.1f, 0, 0, false, 1, 48},
    {"braid", "drawn back to the nape and plaited of three",
     [](GroomParams *p) {
         p->strands = 80000;
         p->length = 27;
         p->clump = 0.95f;
         p->wispClump = 0.9f;
         p->frizz = 0.03f;
         p->flyaways = 0.03f;
         p->volume = 0.6f;
         p->level = 0;
     },
     Comb::Braid, 0.1f, 0, 0, false, 1, 64},
    //<
    //> Comb it forward, back, and wet
    {"short", "a few centimetres, ears and nape free",
     [](GroomParams *p) {
         p->length = 5.5f;
         p->lengthVariation = 0.35f;
         p->locks = 900;
         p->clump = 0.35f;
         p->wispClump = 0.55f;
         p->frizz = 0.06f;
         p->volume = 0.6f;
         p->level = 0;
         p->tip = 0.5f;
     },
     Comb::Whorl, 0.45f, 0.07f, 0, false, 0.3f, 8},
    {"combed-back", "from the forehead over the head, without a parting",
     [](GroomParams *p) {
         p->length = 17;
         p->lengthVariation = 0.2f;
         p->clump = 0.55f;
         p->wispClump = 0.7f;
         p->frizz = 0.03f;
         p->flyaways = 0.015f;
         p->volume = 0.8f;
         p->level = 0;
     },
     Comb::Back, 0.3f, 0.16f, 0, false, 0.8f},
    {"wet", "combed back, hanging in strings; clumps and no flyaways stand in for the film of water",
     [](GroomParams *p) {
         p->length = 30;
         p->clump = 0.8f;
         p->wisps = 2200;
         p->wispClump = 0.97f;
         p->frizz = 0.015f;
         p->flyaways = 0.002f;
         p->volume = 0.35f;
         p->level = 0.4f;
     },
     Comb::Back, 0.15f, 0.2f},
    //<
};
//<
constexpr auto kStyleNames = [] {
    std::array<std::string_view, std::size(kStyles)> names{};
    for (size_t i = 0; i < names.size(); ++i)
        names[i] = kStyles[i].name;
    return names;
}();

//> Tabulate the parameters
constexpr GroomParamInfo kTable[] = {
    {"strands", &GroomParams::strands, 1, 2e7, "all",
     "number of strands (a hair cube takes the nearest square)"},
    {"seed", &GroomParams::seed, 0, 2147483647, "all", "another seed is another groom of the same kind"},
    {"segments", &GroomParams::segments, 0, 1000, "all",
     "curve segments of a strand; 0: as many as the style needs"},
    {"width", &GroomParams::width, 1e-6, 100, "all", "diameter of a hair at its root"},
    {"width_scale", &GroomParams::widthScale, 1e-3, 1000, "all",
     "factor on all widths, so that fewer strands cover as much"},
    {"tip", &GroomParams::tip, 0, 1, "all", "width at the tip as a fraction of the root's"},
    {"length", &GroomParams::length, 0.01, 500, "head fur-ball",
     "length of the longest hairs (cm), curls not counted"},
    {"length_variation", &GroomParams::lengthVariation, 0, 0.95, "head fur-ball",
     "how much shorter the shortest hairs are, as a fraction"},
    {"locks", &GroomParams::locks, 1, 100000, "head fur-ball",
     "number of guide hairs, each the middle of a lock"},
    {"clump", &GroomParams::clump, 0, 1, "head fur-ball",
     "how far the hairs of a lock draw together toward the tip"},
    {"wisps", &GroomParams::wisps, 1, 1000000, "head fur-ball",
     "number of wisps that the locks divide into, no more than strands"},
    {"wisp_clump", &GroomParams::wispClump, 0, 1, "head fur-ball",
     "how far the hairs of a wisp draw together toward the tip"},
    {"curl_radius", &GroomParams::curlRadius, 0, 20, "head fur-ball",
     "radius of the curls, half the width of waves (cm)"},
    {"curl_length", &GroomParams::curlLength, 0.1, 200, "head fur-ball",
     "length of hair per turn or wave (cm)"},
    {"frizz", &GroomParams::frizz, 0, 10, "head fur-ball",
     "how far single hairs stray from their neighbours (cm)"},
    {"flyaways", &GroomParams::flyaways, 0, 1, "head fur-ball",
     "fraction of the hairs that keep out of the locks"},
    {"volume", &GroomParams::volume, 0, 10, "head",
     "thickness of the hair over the scalp (cm) where it is thickest"},
    {"part", &GroomParams::part, -7, 7, "head", "where the hair parts: cm to the head's left of its middle"},
    {"level", &GroomParams::level, 0, 1, "head",
     "0: all hairs as long, in layers; 1: cut to end at one height"},
    {"color_from", &GroomParams::colorFrom, 0, 1, "all",
     "where along a hair tip_color begins, as a fraction of its length (a little different for each)"},
    {"color_variation", &GroomParams::colorVariation, 0, 1, "all",
     "how much lighter and darker single hairs are (of those with root_color)"},
    {"grey", &GroomParams::grey, 0, 1, "all",
     "fraction of the hairs that are white (of those with root_color)"},
    {"radius", &GroomParams::radius, 1e-3, 1e6, "fur-ball ball",
     "radius of the skin under the fur; of the ball"},
    {"side", &GroomParams::side, 1e-3, 1e6, "hair-cube", "side of the hair cube"},
};

constexpr GroomColorInfo kColors[] = {
    {"root_color", &GroomParams::rootColor,
     "colour of the hair, 0 to 1 each; a hair material shows it by a texture \"strandcolor\""},
    {"tip_color", &GroomParams::tipColor,
     "colour that the lengths are dyed with, 0 to 1 each (with root_color)"},
};
//<

template <size_t n>
std::string Choices(const std::array<std::string_view, n> &names) {
    std::string all;
    for (const std::string_view name : names)
        all += (all.empty() ? "" : ", ") + std::string(name);
    return all;
}

std::string Number(double v) {
    std::ostringstream out;
    out << v;
    return out.str();
}

} // namespace

bool GroomReads(std::string_view kind, const GroomParamInfo &info) {
    if (info.kinds == "all")
        return true;
    std::istringstream in{std::string(info.kinds)};
    for (std::string word; in >> word;)
        if (word == kind)
            return true;
    return false;
}

std::span<const GroomParamInfo> GroomParamTable() { return kTable; }
std::span<const GroomColorInfo> GroomColorTable() { return kColors; }
std::span<const std::string_view> GroomKinds() { return kKinds; }
std::span<const HeadStyleInfo> HeadStyleTable() { return kStyles; }
std::span<const std::string_view> HeadStyles() { return kStyleNames; }

//> Find a style
const HeadStyleInfo &FindHeadStyle(std::string_view name) {
    const auto *found = std::find_if(std::begin(kStyles), std::end(kStyles),
                                     [&](const HeadStyleInfo &style) { return style.name == name; });
    if (found == std::end(kStyles))
        throw Error("unknown style of a head \"{}\"; the styles are {}", name, Choices(kStyleNames));
    return *found;
}
//<

//> Begin with what a kind and a style bring
GroomParams MakeGroomParams(std::string_view kind, std::string_view style) {
    GroomParams p;
    p.kind = kind;
    p.style = style;
    if (std::find(kKinds.begin(), kKinds.end(), kind) == kKinds.end())
        throw Error("unknown kind of groom \"" + p.kind + "\"; the kinds are " + Choices(kKinds));
    if (kind != "head" && !style.empty())
        throw Error("a groom of kind \"" + p.kind + "\" has no styles; \"" + p.style + "\" is for nothing");
    if (kind == "head") {
        if (style.empty())
            p.style = kStyles[0].name;
        FindHeadStyle(p.style).set(&p);
    } else if (kind == "fur-ball") {
        p.strands = 60000;
        p.radius = 8;
        p.length = 3.2f;
        p.lengthVariation = 0.4f;
        p.locks = 1500;
        p.clump = 0.6f;
        p.wispClump = 0.5f;
        p.frizz = 0.1f;
        p.width = 0.007f;
        p.tip = 0.1f;
        p.flyaways = 0.1f;
    } else if (kind == "hair-cube") {
        p.strands = 10000;
        p.width = 0.02f; // touching neighbours: a side of 2 holds 100 of them
        p.tip = 1;
    } else { // ball
        p.strands = 50000;
        p.width = 0.004f;
        p.tip = 1;
    }
    return p;
}
//<

//> Find a parameter by its name
const GroomParamInfo &FindGroomParam(std::string_view name, std::string_view kind) {
    std::vector<std::string_view> names;
    for (const GroomParamInfo &info : kTable) {
        if (info.name == name) {
            if (GroomReads(kind, info))
                return info;
            throw Error("a groom of kind \"" + std::string(kind) + "\" has no parameter \"" +
                        std::string(name) + "\"; it is for " + std::string(info.kinds));
        }
        if (GroomReads(kind, info))
            names.push_back(info.name);
    }
    throw Error("unknown groom parameter \"" + std::string(name) + "\". " +
                Suggestion(name, names.data(), names.size()));
}
//<

//> Set a parameter
void SetGroomParam(GroomParams *params, std::string_view name, double value) {
    const GroomParamInfo &info = FindGroomParam(name, params->kind);
    const std::string what = "groom parameter \"" + std::string(name) + "\" ";
    const bool whole = std::holds_alternative<int GroomParams::*>(info.member);
    // Bounds that are no binary32 numbers include the nearest one.
    const auto rounded = [whole](double v) { return whole ? v : static_cast<double>(static_cast<float>(v)); };
    if (!(rounded(value) >= rounded(info.min) && rounded(value) <= rounded(info.max)))
        throw Error(what + "must lie between " + Number(info.min) + " and " + Number(info.max) + ", not " +
                    Number(value));
    if (whole) {
        if (value != std::floor(value))
            throw Error(what + "must be a whole number, not " + Number(value));
        params->*(std::get<int GroomParams::*>(info.member)) = static_cast<int>(value);
    } else {
        params->*(std::get<float GroomParams::*>(info.member)) = static_cast<float>(value);
    }
}

void SetGroomParam(GroomParams *params, std::string_view name, const std::string &value) {
    double v = 0;
    const char *end = value.data() + value.size();
    const auto [stop, status] = std::from_chars(value.data(), end, v);
    if (status != std::errc() || stop != end)
        throw Error("groom parameter \"" + std::string(name) + "\" must be a number, not \"" + value + "\"");
    SetGroomParam(params, name, v);
}
//<

//> Set a colour
void SetGroomColor(GroomParams *params, std::string_view name, const Spectrum &value) {
    const auto *info = std::find_if(std::begin(kColors), std::end(kColors),
                                    [&](const GroomColorInfo &c) { return c.name == name; });
    if (info == std::end(kColors))
        throw Error("unknown groom colour \"" + std::string(name) + "\"");
    for (int c = 0; c < 3; ++c)
        if (!(value[c] >= 0 && value[c] <= 1))
            throw Error("groom parameter \"" + std::string(name) +
                        "\" is a colour of numbers from 0 to 1, not " +
                        Number(static_cast<double>(value[c])));
    params->*(info->member) = value;
}

void SetGroomColor(GroomParams *params, std::string_view name, const std::string &value) {
    Spectrum color;
    const char *at = value.data(), *end = at + value.size();
    for (int c = 0; c < 3; ++c) {
        const auto [stop, status] = std::from_chars(at, end, color[c]);
        at = stop;
        if (status != std::errc() || (c < 2 ? at == end || *at++ != ',' : at != end))
            throw Error("groom parameter \"" + std::string(name) + "\" must be three numbers R,G,B, not \"" +
                        value + "\"");
    }
    SetGroomColor(params, name, color);
}
//<

double GetGroomParam(const GroomParams &params, std::string_view name) {
    const GroomParamInfo &info = FindGroomParam(name, params.kind);
    if (const auto *member = std::get_if<int GroomParams::*>(&info.member))
        return params.*(*member);
    return static_cast<double>(params.*(std::get<float GroomParams::*>(info.member)));
}

//> Write the manual of a groom's parameters
std::span<const ParamInfo> GroomParamRows() {
    static const std::deque<std::string> defaults = [] {
        const GroomParams head = MakeGroomParams("head");
        std::deque<std::string> texts;
        for (const GroomParamInfo &info : GroomParamTable())
            texts.push_back(GroomReads("head", info) ? fmt::format("{:g}", GetGroomParam(head, info.name))
                                                     : "");
        return texts;
    }();
    static const std::vector<ParamInfo> params = [] {
        std::vector<ParamInfo> infos{
            ChoiceParam("kind", GroomKinds(), "what is grown; other kinds have other defaults"),
            ChoiceParam("style", HeadStyles(), "of a head; other styles have other defaults"),
        };
        for (size_t i = 0; const GroomParamInfo &info : GroomParamTable())
            infos.push_back({info.name,
                             std::holds_alternative<int GroomParams::*>(info.member) ? "integer" : "float",
                             "", defaults[i++], info.help, info.min, info.max});
        for (const GroomColorInfo &info : GroomColorTable())
            infos.push_back({info.name, "spectrum", "", "", info.help, 0, 1});
        return infos;
    }();
    return params;
}
//<

} // namespace cuticle
//<
