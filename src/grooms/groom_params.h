//> Declare the parameters of a groom
// The parameters of procedural grooms: one table serves the command line and the scene language.
#pragma once

#include "core/color.h"
#include "core/param_info.h"

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>

namespace cuticle {

//> List what a groom can be told
// Lengths are in centimetres for heads and fur, in the units of `radius` and `side` otherwise.
struct GroomParams {
    std::string kind = "head";      // head, fur-ball, hair-cube, ball
    std::string style = "straight"; // of a head: a row of HeadStyleTable

    int strands = 100000;
    int seed = 1;
    int segments = 0; // curve segments of a strand; 0: as many as the style needs
    float width = 0.007f;
    float tip = 0.35f; // width at the tip, as a fraction of that at the root
    float widthScale = 1;

    // Heads and fur.
    float length = 34;
    float lengthVariation = 0.15f;
    int locks = 700;
    float clump = 0.5f;
    int wisps = 6000;
    float wispClump = 0.6f;
    float curlRadius = 0;
    float curlLength = 5;
    float frizz = 0.05f;
    float flyaways = 0.03f;
    float volume = 1;
    float part = 2;
    float level = 0.6f;

    // Colours, linear RGB of a mass of such hair; without rootColor the strands have none of their own. Hair
    // is dyed with tipColor from about colorFrom of its length on.
    std::optional<Spectrum> rootColor, tipColor;
    float colorFrom = 0.4f;
    float colorVariation = 0.15f; // of the absorption, from hair to hair
    float grey = 0;               // fraction of the hairs that have no pigment
    float radius = 1;             // of the fur ball's skin, of the ball
    float side = 2;               // of the hair cube
};
//<

//> Describe one parameter
// One parameter: its name in a scene file ("curl_radius"; the command line says --curl-radius), where it is
// kept, what values it takes, which kinds of groom read it.
struct GroomParamInfo {
    std::string_view name;
    std::variant<int GroomParams::*, float GroomParams::*> member;
    double min, max;
    std::string_view kinds; // "head fur-ball", or "all"
    std::string_view help;
};
std::span<const GroomParamInfo> GroomParamTable();
// Whether a kind of groom reads that parameter.
bool GroomReads(std::string_view kind, const GroomParamInfo &info);
//<

// The colours among the parameters, which every kind of groom reads: "root_color", "tip_color".
struct GroomColorInfo {
    std::string_view name;
    std::optional<Spectrum> GroomParams::*member;
    std::string_view help;
};
std::span<const GroomColorInfo> GroomColorTable();

// The kinds.
std::span<const std::string_view> GroomKinds();

//> Name the ways to comb
// Says which way hair leaves a head.
enum class Comb {
    Part,  // away from a parting, and down
    Whorl, // around the crown and forward, as short hair grows
    Back,  // from the forehead over the head, and down behind
    Out,   // away from the skin on all sides
    Bun,   // drawn to the back of the head and wound up there
    Braid  // drawn to the nape and plaited
};
//<

//> Describe a style
// A style of a head: what it is, how hair is combed, and the parameters that differ from those of straight
// hair.
struct HeadStyleInfo {
    std::string_view name, help;
    void (*set)(GroomParams *) = nullptr;
    Comb comb = Comb::Part;
    float lift = 0.45f;   // how steeply hair leaves the skin, 0 along it
    float weight = 0.24f; // how fast it bends down: the share of gravity in its direction, per cm
    float turnIn = 0;     // how fast its ends turn toward the neck, per cm
    bool waves = false;   // curls lie in a plane and in step with their neighbours
    float sides = 1;      // length at the sides and the nape, as a share of that on top
    int segments = 0;     // of a strand; 0: by length and curls
};
//<
std::span<const HeadStyleInfo> HeadStyleTable();
std::span<const std::string_view> HeadStyles(); // their names
// Throws Error naming the choices.
const HeadStyleInfo &FindHeadStyle(std::string_view name);

// The defaults of a kind and (heads only) style; an empty style is the first. Throws Error naming the
// choices. A style that is really a kind ("fur-ball") is an Error too.
GroomParams MakeGroomParams(std::string_view kind, std::string_view style = {});

// The table's row of that name, or an Error with the nearest names; also an Error when `kind` does not read
// it.
const GroomParamInfo &FindGroomParam(std::string_view name, std::string_view kind);

// Sets one parameter. Throws Error for an unknown name, a value out of range, NaN, a fraction where a whole
// number belongs, or text that is no number.
void SetGroomParam(GroomParams *params, std::string_view name, double value);
void SetGroomParam(GroomParams *params, std::string_view name, const std::string &value);
// A colour of the table; three numbers from 0 to 1, in text "R,G,B". Throws Error as above.
void SetGroomColor(GroomParams *params, std::string_view name, const Spectrum &value);
void SetGroomColor(GroomParams *params, std::string_view name, const std::string &value);
double GetGroomParam(const GroomParams &params, std::string_view name);

//> Read the parameters of a groom from a scene
// The parameters of Shape "groom" in scenes, and of Hair "groom" in recipes of simulations: those of the
// tables, with "kind" and "style", in the types of a scene. Defaults are those of a head of straight hair.
std::span<const ParamInfo> GroomParamRows();
// Returns what a set of such parameters (a ParamSet of the parser) asks for. Throws Error as SetGroomParam
// does.
template <class Parameters>
GroomParams GroomParamsOf(const Parameters &p) {
    const std::string kind = p.FindString("kind", "head");
    GroomParams params = MakeGroomParams(kind, p.FindString("style", ""));
    for (const GroomParamInfo &info : GroomParamTable())
        if (p.Find(info.name) && GroomReads(kind, info))
            SetGroomParam(&params, info.name,
                          std::holds_alternative<int GroomParams::*>(info.member)
                              ? static_cast<double>(p.FindInt(info.name, 0))
                              : static_cast<double>(p.FindFloat(info.name, 0)));
    for (const GroomColorInfo &info : GroomColorTable())
        if (p.Find(info.name))
            SetGroomColor(&params, info.name, p.FindSpectrum(info.name, Spectrum(0)));
    return params;
}
//<

} // namespace cuticle
//<
