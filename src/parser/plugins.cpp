#include "parser/plugins.h"

#include <array>

namespace cuticle {

const PluginTable &Plugins(PluginKind kind) {
    static const std::array<PluginTable, kPluginKinds> tables{{
        {"Camera",
         {{"perspective"},
          {"orthographic"},
          {"environment"},
          {"realistic", "a perspective camera with a thin lens of the same focal length"}},
         {"spherical"},
         {},
         "the first two with a thin lens"},
        {"Sampler",
         {{"halton"},
          {"sobol"},
          {"random"},
          {"stratified"},
          {"02sequence"},
          {"lowdiscrepancy"},
          {"maxmindist"}},
         {"independent", "zsobol", "paddedsobol", "pmj02bn"},
         {"adaptive", "bestcandidate"},
         "each but random is one Owen-scrambled Sobol' sampler"},
        {"Film", {{"image"}}, {"rgb", "gbuffer", "spectral"}, {}, ""},
        {"PixelFilter", {{"box"}, {"gaussian"}, {"mitchell"}, {"sinc"}, {"triangle"}}, {}, {}, ""},
        {"Integrator",
         {{"path"},
          {"directlighting"},
          {"whitted"},
          {"volpath", "path"},
          {"bdpt", "path"},
          {"mlt", "path"},
          {"sppm", "path"},
          {"ambientocclusion", "path"},
          {"ao", "path"}},
         {"simplepath", "simplevolpath", "lightpath", "randomwalk", "function"},
         {"photonmap", "exphotonmap", "igi", "irradiancecache", "diffuseprt", "glossyprt", "useprobes",
          "dipolesubsurface"},
         ""},
        {"Accelerator", {{"bvh"}, {"kdtree"}}, {}, {"grid", "none"}, "read; both mean our own"},
        {"Shape",
         {{"curve"},
          {"trianglemesh"},
          {"plymesh"},
          {"loopsubdiv"},
          {"heightfield"},
          {"sphere"},
          {"disk"},
          {"cylinder"},
          {"cone"},
          {"paraboloid"},
          {"hyperboloid"},
          {"nurbs", "left out of the picture"},
          {"hairfile", {}, true},
          {"groom", {}, true},
          {"groomhead", {}, true}},
         {"bilinearmesh"},
         {},
         "curves of every type, basis and degree; objects are stored once, however many instances; alpha and "
         "shadowalpha on meshes"},
        {"Material",
         {{"hair"},
          {"matte"},
          {"plastic"},
          {"mirror"},
          {"glass"},
          {"uber"},
          {"metal"},
          {"substrate"},
          {"translucent"},
          {"disney"},
          {"mix"},
          {""},
          {"none"},
          {"subsurface", "a coated diffuse surface of the reflectance that the medium implies"},
          {"kdsubsurface", "a coated diffuse surface of the colour \"Kd\""},
          {"fourier", "a matte surface of reflectance 0.5"}},
         {"coateddiffuse", "coatedconductor", "conductor", "dielectric", "diffuse", "diffusetransmission",
          "interface", "thindielectric", "measured"},
         {"shinymetal"},
         "bump maps on all surfaces but hair"},
        {"Texture",
         {{"constant"},
          {"scale"},
          {"mix"},
          {"imagemap"},
          {"checkerboard"},
          {"bilerp"},
          {"uv"},
          {"dots"},
          {"fbm"},
          {"wrinkled"},
          {"windy"},
          {"marble"},
          {"ptex", "the constant 0.5"},
          {"strandcolor", {}, true}},
         {"directionmix"},
         {},
         "all mappings; images from exr, pfm, png, tga, hdr, jpg"},
        {"LightSource",
         {{"infinite"}, {"exinfinite"}, {"distant"}, {"point"}, {"spot"}, {"goniometric"}, {"projection"}},
         {},
         {"infinitesample"},
         "maps are sampled by importance"},
        {"AreaLightSource",
         {{"diffuse"}, {"area"}},
         {},
         {},
         "on surfaces; on curves and inside objects it is one warning"},
        {"MakeNamedMedium",
         {{"homogeneous", "empty space"}, {"heterogeneous", "empty space"}},
         {"uniformgrid", "rgbgrid", "cloud", "nanovdb"},
         {},
         ""},
    }};
    return tables[static_cast<size_t>(kind)];
}

std::vector<std::string_view> PluginNames(PluginKind kind) {
    std::vector<std::string_view> names;
    for (const Plugin &plugin : Plugins(kind).known)
        names.push_back(plugin.name);
    return names;
}

std::string_view StandInOf(PluginKind kind, std::string_view name) {
    for (const Plugin &plugin : Plugins(kind).known)
        if (plugin.name == name)
            return plugin.standIn;
    return {};
}

namespace {

std::string Join(const std::vector<std::string> &parts, const char *between) {
    std::string text;
    for (const std::string &part : parts)
        text += (text.empty() ? "" : between) + part;
    return text;
}

std::string FeatureRow(const PluginTable &table) {
    std::vector<std::string> rendered, ours, standIns;
    std::vector<std::vector<std::string>> replaced; // by each of standIns
    for (const Plugin &plugin : table.known) {
        const std::string name = plugin.name.empty() ? "`\"\"`" : std::string(plugin.name);
        if (plugin.standIn.empty()) {
            (plugin.ours ? ours : rendered).push_back(name);
            continue;
        }
        if (standIns.empty() || standIns.back() != plugin.standIn) {
            standIns.emplace_back(plugin.standIn);
            replaced.emplace_back();
        }
        replaced.back().push_back(name);
    }
    std::vector<std::string> left, right;
    if (!rendered.empty())
        left.push_back(Join(rendered, ", "));
    if (!ours.empty())
        left.push_back("ours: " + Join(ours, ", "));
    if (!table.remark.empty())
        left.emplace_back(table.remark);
    for (size_t i = 0; i < standIns.size(); ++i)
        right.push_back(Join(replaced[i], ", ") + ": " + standIns[i]);
    return "| `" + std::string(table.directive) + "` | " + Join(left, "; ") + " | " + Join(right, "; ") +
           " |\n";
}

} // namespace

std::string FeatureTable() {
    std::string text =
        "| directive | rendered | known, with a warning and what is used instead |\n| --- | --- | --- |\n";
    for (size_t kind = 0; kind < kPluginKinds; ++kind)
        text += FeatureRow(Plugins(static_cast<PluginKind>(kind)));
    return text + "| `ActiveTransform`, `TransformTimes` | | motion: the place at the start time |\n";
}

} // namespace cuticle
