#include "materials/hair_models.h"

#include <algorithm>
#include <deque>
#include <limits>
#include <mutex>
#include <sstream>

namespace cuticle {

namespace {

// Every model takes these, whatever its own parameters are. pbrt-v3's names and defaults, but for "model".
constexpr ParamInfo kCommon[] = {
    {"model", "string", "", "chiang", "the model of a fiber; below, the parameters of all of them"},
    {"sigma_a", "spectrum texture", "1/radius", "", "absorption of the fiber; comes before any other colour",
     0},
    {"color", "spectrum texture", "", "", "of a dense head of this hair (Chiang et al. 2016)", 0, 1},
    {"reflectance", "spectrum texture", "", "", "another name of color", 0, 1},
    {"eumelanin", "float texture", "", "1.3 where no colour is given, else 0",
     "concentration of brown pigment", 0},
    {"pheomelanin", "float texture", "", "0", "concentration of red pigment", 0},
    {"eta", "float texture", "", "1.55", "index of refraction; all models but chiang: from 1.001", 1e-3, 1e3},
    {"beta_m", "float texture", "", "0.3", "roughness along the fiber", 0, 1},
    {"beta_n", "float texture", "", "0.3", "roughness around the fiber", 0, 1},
    {"alpha", "float texture", "degrees", "2", "tilt of the cuticle's scales"},
    {"bumpmap", "float texture", "lengths of the scene", "", "is not rendered on hair"},
};

// Textures are clamped where they are looked up, and nothing is said of them.
void WarnOfNumbersOutOfRange(const ParamSet &params, const FiberModel &model) {
    constexpr double kNoLimit = std::numeric_limits<double>::infinity();
    for (const ParamInfo &row : HairMaterialParams()) {
        const Param *p = params.Find(row.name);
        if (!p || (p->type != ParamType::Float && p->type != ParamType::Spectrum))
            continue;
        const double low = row.name == "eta" ? model.minEta : row.low;
        const auto outside = std::find_if(p->numbers.begin(), p->numbers.end(),
                                          [&](double x) { return !(x >= low && x <= row.high); });
        if (outside == p->numbers.end())
            continue;
        std::ostringstream says;
        says << "hair: \"" << row.name << "\" is " << *outside << " and is taken as "
             << (*outside < low ? low : row.high) << "; it may be " << low
             << (row.high < kNoLimit ? " to " : " or more");
        if (row.high < kNoLimit)
            says << row.high;
        Warning(p->loc, "hair parameter out of range: " + p->name, says.str());
    }
}

} // namespace

std::vector<ParamInfo> HairMaterialParams() {
    std::vector<ParamInfo> all(std::begin(kCommon), std::end(kCommon));
    // The rows' texts live as long as the program, so does the list of names that the row of "model" shows.
    static std::deque<std::vector<std::string_view>> lists;
    static std::mutex mutex;
    {
        const std::lock_guard lock(mutex);
        if (lists.empty() || lists.back().size() != FiberModels().size())
            lists.push_back(HairModelNames());
        all.front().choices = lists.back();
    }
    for (const FiberModel &model : FiberModels())
        for (const ParamInfo &own : model.params)
            if (std::none_of(all.begin(), all.end(), [&](const ParamInfo &p) { return p.name == own.name; }))
                all.push_back(own);
    return all;
}

std::vector<std::string_view> HairModelNames() {
    std::vector<std::string_view> names;
    for (const FiberModel &model : FiberModels())
        names.push_back(model.name);
    return names;
}

std::unique_ptr<Material> MakeHairMaterial(const ParamSet &params, const TextureTable &textures,
                                           const MaterialOptions &options) {
    const std::string asked = params.FindString("model", std::string(FiberModels().front().name));
    const std::string &name = options.hairModel.empty() ? asked : options.hairModel;
    const FiberModel *model = FindFiberModel(name);
    if (!model) {
        const std::vector<std::string_view> names = HairModelNames();
        const Param *given = params.Find("model");
        throw Error(given ? given->loc : params.loc, "unknown hair model \"{}\"", name)
            .WithRemedy(Suggestion(name, names.data(), names.size()));
    }
    WarnOfNumbersOutOfRange(params, *model);
    return std::make_unique<HairMaterial>(*model, params, textures, options);
}

} // namespace cuticle
