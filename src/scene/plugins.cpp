#include "scene/plugins.h"

namespace cuticle {

// To add a camera: a row here, and its rays in Camera (scene/camera.cpp).
const PluginTable &CameraPlugins() {
    static const PluginTable table{
        PluginKind::Camera,
        {{.name = "perspective"},
         {.name = "orthographic"},
         {.name = "environment"},
         {.name = "realistic", .standIn = "a perspective camera with a thin lens of the same focal length"}},
        {"spherical"},
        {},
        "the first two with a thin lens"};
    return table;
}

// To add a shape: a row here, and its making in scene/scene.cpp.
const PluginTable &ShapePlugins() {
    static const PluginTable table{
        PluginKind::Shape,
        {{.name = "curve"},
         {.name = "trianglemesh"},
         {.name = "plymesh"},
         {.name = "loopsubdiv"},
         {.name = "heightfield"},
         {.name = "sphere"},
         {.name = "disk"},
         {.name = "cylinder"},
         {.name = "cone"},
         {.name = "paraboloid"},
         {.name = "hyperboloid"},
         {.name = "nurbs", .standIn = "left out of the picture"},
         {.name = "hairfile", .ours = true},
         {.name = "groom", .ours = true},
         {.name = "groomhead", .ours = true}},
        {"bilinearmesh"},
        {},
        "curves of every type, basis and degree; objects are stored once, however many instances; alpha and "
        "shadowalpha on meshes"};
    return table;
}

// To add a light: a row here, and its making in scene/light.cpp.
const PluginTable &LightPlugins() {
    static const PluginTable table{PluginKind::Light,
                                   {{.name = "infinite"},
                                    {.name = "exinfinite"},
                                    {.name = "distant"},
                                    {.name = "point"},
                                    {.name = "spot"},
                                    {.name = "goniometric"},
                                    {.name = "projection"}},
                                   {},
                                   {"infinitesample"},
                                   "maps are sampled by importance"};
    return table;
}

const PluginTable &AreaLightPlugins() {
    static const PluginTable table{PluginKind::AreaLight,
                                   {{.name = "diffuse"}, {.name = "area"}},
                                   {},
                                   {},
                                   "on surfaces; on curves and inside objects it is one warning"};
    return table;
}

// Media are read and not rendered: the parser warns of them.
const PluginTable &MediumPlugins() {
    static const PluginTable table{PluginKind::Medium,
                                   {{.name = "homogeneous", .standIn = "empty space"},
                                    {.name = "heterogeneous", .standIn = "empty space"}},
                                   {"uniformgrid", "rgbgrid", "cloud", "nanovdb"}};
    return table;
}

} // namespace cuticle
