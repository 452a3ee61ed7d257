#include "parser/spd_file.h"

#include "core/error.h"
#include "files/file.h"

#include <cmath>
#include <sstream>
#include <vector>

namespace cuticle {

Spectrum ParseSPD(const std::string &text, const std::string &name) {
    FileLoc loc{std::make_shared<const std::string>(name), 0, 0};
    std::vector<double> numbers;
    std::istringstream in(text);
    std::string line;
    while (std::getline(in, line)) {
        ++loc.line;
        const std::string whole = line;
        line = line.substr(0, line.find('#'));
        for (size_t at = line.find_first_not_of(" \t\r,"); at != std::string::npos;) {
            const size_t end = std::min(line.find_first_of(" \t\r,", at), line.size());
            const std::string word = line.substr(at, end - at);
            size_t read = 0;
            double value = 0;
            try {
                value = std::stod(word, &read);
            } catch (const std::exception &) {
                read = 0;
            }
            if (read != word.size() || !std::isfinite(value)) {
                loc.column = static_cast<uint32_t>(at + 1);
                throw Error(loc, "\"{}\" is not a finite number", word.substr(0, 40))
                    .WithRemedy("the file holds wavelengths (nm) and values")
                    .WithSourceLine(whole);
            }
            numbers.push_back(value);
            at = line.find_first_not_of(" \t\r,", end);
        }
    }
    if (numbers.empty() || numbers.size() % 2 != 0)
        throw Error(loc, "the file holds {} numbers", numbers.size())
            .WithRemedy("pairs of wavelength and value were expected");
    std::vector<double> lambda, values;
    for (size_t i = 0; i < numbers.size(); i += 2)
        lambda.push_back(numbers[i]), values.push_back(numbers[i + 1]);
    const Spectrum color = SpectrumFromSamples(std::move(lambda), std::move(values));
    if (!color.IsFinite())
        throw Error(FileLoc{loc.file, 0, 0}, "the colour of these values is out of range");
    return color;
}

Spectrum ReadSPD(const std::string &filename) {
    return ParseSPD(ReadFile(filename, "the spectrum file"), filename);
}

} // namespace cuticle
