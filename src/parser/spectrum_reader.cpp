// The part of ParamReader that turns the spellings of a spectrum into linear RGB.
#include "core/metal_spectra.h"
#include "parser/param_reader.h"
#include "parser/spd_file.h"

#include <cfloat>
#include <cmath>
#include <filesystem>

namespace cuticle {

namespace {

void AddRGB(const Spectrum &s, Param *p) { p->numbers.insert(p->numbers.end(), {s[0], s[1], s[2]}); }

} // namespace

void ParamReader::ToSpectrum(Reading *r) {
    Param &p = r->param;
    const std::vector<double> in = std::move(p.numbers);
    p.numbers.clear();
    switch (r->spelling) {
    case SpectrumSpelling::RGB:
    case SpectrumSpelling::XYZ:
        if (in.empty() || in.size() % 3 != 0)
            text_.Fail(r->declaration, "\"{}\" is a colour of 3 numbers (or several), not of {}", p.name,
                       in.size());
        if (r->spelling == SpectrumSpelling::RGB)
            p.numbers = in;
        else
            for (size_t i = 0; i < in.size(); i += 3)
                AddRGB(XYZToRGB({in[i], in[i + 1], in[i + 2]}), &p);
        break;
    case SpectrumSpelling::Blackbody:
        FromBlackbodies(in, r);
        break;
    case SpectrumSpelling::Samples:
        if (p.strings.empty())
            FromSamples(in, r);
        else
            FromSpectrumFiles(r);
        break;
    case SpectrumSpelling::None:
        break;
    }
    for (const double v : p.numbers)
        if (!(std::abs(v) <= FLT_MAX))
            text_.Fail(r->declaration, "the colour of \"{}\" is out of range (largest 3.4e38)", p.name);
}

void ParamReader::FromBlackbodies(const std::vector<double> &in, Reading *r) {
    Param &p = r->param;
    if (in.size() == 1)
        text_.Fail(
            r->declaration,
            "\"blackbody {}\" takes a temperature in kelvin and a scale; a temperature alone is pbrt-v4, "
            "and Cuticle reads pbrt-v3",
            p.name);
    if (in.empty() || in.size() % 2 != 0)
        text_.Fail(r->declaration,
                   "\"blackbody {}\" takes pairs of temperature in kelvin and scale, not {} numbers", p.name,
                   in.size());
    for (size_t i = 0; i < in.size(); i += 2) {
        if (!(in[i] > 0))
            text_.Fail(r->declaration, "the temperature of \"blackbody {}\" must be above 0 kelvin", p.name);
        AddRGB(BlackbodyToRGB(in[i], in[i + 1]), &p);
    }
}

void ParamReader::FromSamples(const std::vector<double> &in, Reading *r) {
    Param &p = r->param;
    if (in.empty() || in.size() % 2 != 0)
        text_.Fail(r->declaration,
                   "\"spectrum {}\" takes pairs of wavelength in nm and value, not {} numbers{}", p.name,
                   in.size(), in.size() == 1 ? " (one number alone is pbrt-v4)" : "");
    std::vector<double> lambda, values;
    for (size_t i = 0; i < in.size(); i += 2) {
        if (!(in[i] > 0))
            text_.Fail(r->declaration, "a wavelength of \"spectrum {}\" must be above 0 nm", p.name);
        lambda.push_back(in[i]);
        values.push_back(in[i + 1]);
    }
    AddRGB(SpectrumFromSamples(std::move(lambda), std::move(values)), &p);
}

void ParamReader::FromSpectrumFiles(Reading *r) {
    Param &p = r->param;
    for (size_t i = 0; i < p.strings.size(); ++i) {
        const std::array<double, 3> &rgb = SpectrumFile(p.strings[i], r->places[i], p.loc);
        p.numbers.insert(p.numbers.end(), rgb.begin(), rgb.end());
    }
    p.strings.clear();
}

// Linear RGB of a .spd file, which is read once; of a metal that scenes name, from our table where it is
// missing.
const std::array<double, 3> &ParamReader::SpectrumFile(const std::string &name, const char *at,
                                                       const FileLoc &param) {
    for (const std::string_view prefix : {"metal-", "glass-", "stdillum-", "illum-"})
        if (name.starts_with(prefix) && name.find('.') == std::string::npos)
            text_.Fail(at,
                       "the named spectrum {} is pbrt-v4: this looks like a pbrt-v4 scene, and Cuticle reads "
                       "pbrt-v3",
                       Quoted(name));
    const std::string path = ResolveFilename(*text_.Folder(), name);
    if (const auto it = spectrumFiles_.find(path); it != spectrumFiles_.end())
        return it->second;
    std::error_code ec;
    Spectrum s;
    if (std::filesystem::exists(path, ec)) {
        const PlaceScope here(text_.lexer().Loc(at));
        s = ReadSPD(path);
    } else if (auto metal = FindMetalSpectrumByFilename(name)) {
        Warning(param, "a metal's spectrum file is missing",
                fmt::format("the spectrum file \"{}\" is missing; the built-in table ({}) is used instead",
                            path, metal->source));
        s = SpectrumFromSamples(std::move(metal->lambda), std::move(metal->values));
    } else {
        text_.missingFile = true;
        text_.Fail(at, "cannot open the spectrum file \"{}\": No such file or directory", path);
    }
    return spectrumFiles_.emplace(path, std::array<double, 3>{s[0], s[1], s[2]}).first->second;
}

} // namespace cuticle
