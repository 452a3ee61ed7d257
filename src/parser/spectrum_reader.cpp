// The part of ParamReader that turns the spellings of a spectrum into linear RGB.
#include "core/metal_spectra.h"
#include "files/file.h"
#include "parser/param_reader.h"
#include "parser/spd_file.h"

#include <cfloat>
#include <cmath>
#include <filesystem>

namespace cuticle {

namespace {

void AddRGB(const Spectrum &s, Param *p) { p->numbers.insert(p->numbers.end(), {s[0], s[1], s[2]}); }

} // namespace

bool ParamReader::WholeGroups(size_t size, std::string_view what, std::vector<double> *in, const Reading &r) {
    const size_t whole = in->size() / size * size;
    if (whole != in->size() || in->empty())
        text_.Complain(r.declaration, "numbers in excess", "{} takes {}, not {} numbers{}; {}, as by pbrt-v3",
                       r.full, what, in->size(),
                       in->empty() ? "" : fmt::format(" (the last is {:g})", in->back()),
                       whole == 0 ? "it is ignored" : "those in excess are ignored");
    in->resize(whole);
    return whole > 0;
}

bool ParamReader::ToSpectrum(Reading *r) {
    Param &p = r->param;
    std::vector<double> in = std::move(p.numbers);
    p.numbers.clear();
    switch (r->spelling) {
    case SpectrumSpelling::RGB:
    case SpectrumSpelling::XYZ:
        if (!WholeGroups(3, "a colour of 3 numbers (or several)", &in, *r))
            return false;
        if (r->spelling == SpectrumSpelling::RGB)
            p.numbers = in;
        else
            for (size_t i = 0; i < in.size(); i += 3)
                AddRGB(XYZToRGB({in[i], in[i + 1], in[i + 2]}), &p);
        break;
    case SpectrumSpelling::Blackbody:
        if (in.size() == 1)
            text_.Fail(r->declaration,
                       "{} takes a temperature in kelvin and a scale; a temperature alone, {:g}, is pbrt-v4, "
                       "and Cuticle reads pbrt-v3",
                       r->full, in[0]);
        if (!WholeGroups(2, "pairs of temperature in kelvin and scale", &in, *r))
            return false;
        FromBlackbodies(in, r);
        break;
    case SpectrumSpelling::Samples:
        if (!p.strings.empty()) {
            FromSpectrumFiles(r);
            break;
        }
        if (in.size() == 1)
            text_.Fail(
                r->declaration,
                "{} takes pairs of wavelength in nm and value; one number alone, {:g}, is pbrt-v4, and "
                "Cuticle reads pbrt-v3",
                r->full, in[0]);
        if (!WholeGroups(2, "pairs of wavelength in nm and value", &in, *r))
            return false;
        FromSamples(in, r);
        break;
    case SpectrumSpelling::None:
        break;
    }
    for (size_t i = 0; i < p.numbers.size(); ++i)
        if (!(std::abs(p.numbers[i]) <= FLT_MAX))
            text_.Fail(r->declaration, "the colour of {} has the {} {:g}; it may be up to 3.4e38", r->full,
                       std::array{"red", "green", "blue"}[i % 3], p.numbers[i]);
    return true;
}

void ParamReader::FromBlackbodies(const std::vector<double> &in, Reading *r) {
    // Hotter than anything, and cold enough for Planck's law in double.
    constexpr double kMaxKelvin = 1e9;
    for (size_t i = 0; i < in.size(); i += 2) {
        if (!(in[i] > 0 && in[i] <= kMaxKelvin))
            text_.Fail(r->declaration,
                       "the temperature of {} is {:g}; it must be above 0 and at most {:g} kelvin", r->full,
                       in[i], kMaxKelvin);
        AddRGB(BlackbodyToRGB(in[i], in[i + 1]), &r->param);
    }
}

void ParamReader::FromSamples(const std::vector<double> &in, Reading *r) {
    std::vector<double> lambda, values;
    for (size_t i = 0; i < in.size(); i += 2) {
        if (!(in[i] > 0))
            text_.Fail(r->declaration, "a wavelength of {} is {:g}; it must be above 0 nm", r->full, in[i]);
        lambda.push_back(in[i]);
        values.push_back(in[i + 1]);
    }
    AddRGB(SpectrumFromSamples(std::move(lambda), std::move(values)), &r->param);
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
    AllowedPath(path); // before it tells whether there is such a file
    if (const auto it = spectrumFiles_.find(path); it != spectrumFiles_.end())
        return it->second;
    std::error_code ec;
    Spectrum s;
    if (std::filesystem::exists(path, ec)) {
        const PlaceScope here(text_.Loc(at));
        s = ReadSPD(path);
    } else if (auto metal = FindMetalSpectrumByFilename(name)) {
        Warning(param, "a metal's spectrum file is missing",
                fmt::format("the spectrum file \"{}\" is missing; the built-in table ({}) is used instead",
                            path, metal->source));
        s = SpectrumFromSamples(std::move(metal->lambda), std::move(metal->values));
    } else {
        text_.Complain(at, "missing spectrum file",
                       "cannot open the spectrum file \"{}\": No such file or directory; it is black, as in "
                       "pbrt-v3",
                       path);
    }
    return spectrumFiles_.emplace(path, std::array<double, 3>{s[0], s[1], s[2]}).first->second;
}

} // namespace cuticle
