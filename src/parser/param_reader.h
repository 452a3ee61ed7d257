// The arguments of directives: strings, numbers, and lists of "type name" values, each kind checked as it is
// read.
#pragma once

#include "parser/graphics_state.h"
#include "parser/param_set.h"
#include "parser/scene_text.h"

#include <array>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

namespace cuticle {

enum class SpectrumSpelling { None, RGB, XYZ, Blackbody, Samples };

// Throws Errors at the token that is wrong. What pbrt-v3 prints a message about and leaves out is a
// Warning, and left out.
class ParamReader {
  public:
    // names: the textures that parameters may name.
    ParamReader(SceneText *text, const ScopedNames *names) : text_(*text), names_(*names) {}

    // `what` in words for the message, as in "a name"; word: the directive.
    std::string ReadString(const Token &word, std::string_view what);
    // N numbers; in brackets too, where a directive allows it.
    template <size_t N>
    std::array<double, N> ReadNumbers(const Token &word, std::string_view what, bool brackets = false) {
        std::array<double, N> values;
        ReadNumbers(word, what, brackets, values.data(), N);
        return values;
    }
    // All parameters that follow.
    ParamSet ReadParams(const Token &word);

  private:
    // One parameter while it is read.
    struct Reading {
        Token declaration;
        SpectrumSpelling spelling = SpectrumSpelling::None;
        std::string full; // "type name" in quotes, for messages
        Param param;
        std::vector<const char *> places; // of param.strings, for messages
        bool hasWords = false;            // true or false without quotes
    };

    void ReadNumbers(const Token &word, std::string_view what, bool brackets, double *values, size_t count);
    void ReadParam(ParamSet *set);
    bool ReadDeclaration(Reading *r);
    void ReadValues(Reading *r);
    void ReadBracketedValues(Reading *r);
    bool TakeValue(const Token &t, Reading *r);
    void ReadNumberArray(std::vector<double> *numbers);
    // Each says whether the parameter counts.
    bool CheckValues(Reading *r);
    bool Convert(Reading *r);
    bool ReadBools(Reading *r);
    bool BindTexture(Reading *r);
    void Add(Reading &&r, ParamSet *set);

    // The spellings of a spectrum, each replaced by triples of linear RGB.
    bool ToSpectrum(Reading *r);
    // Leaves out the values behind the last whole group of `size`, with a Warning; false where none is left.
    bool WholeGroups(size_t size, std::string_view what, std::vector<double> *in, const Reading &r);
    void FromBlackbodies(const std::vector<double> &in, Reading *r);
    void FromSamples(const std::vector<double> &in, Reading *r);
    void FromSpectrumFiles(Reading *r);
    const std::array<double, 3> &SpectrumFile(const std::string &name, const char *at, const FileLoc &param);

    SceneText &text_;
    const ScopedNames &names_;
    std::unordered_map<std::string, std::array<double, 3>> spectrumFiles_; // linear RGB by path
};

} // namespace cuticle
