#include "files/frame_names.h"

#include "core/error.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <filesystem>

namespace cuticle {

namespace {

// A place for a number: the characters [begin, end) of a name. begin is npos where there is none.
struct FramePlace {
    size_t begin = std::string_view::npos, end = 0, width = 0;
    char fill = ' ';
};

// Finds the first place at or behind `from`: a percent sign, up to two digits, a d.
FramePlace FindFramePlace(std::string_view name, size_t from) {
    for (size_t begin = name.find('%', from); begin != std::string_view::npos;
         begin = name.find('%', begin + 1)) {
        FramePlace place{begin, begin + 1};
        for (; place.end < name.size() && place.end < begin + 3; ++place.end) {
            const char c = name[place.end];
            if (c < '0' || c > '9')
                break;
            if (place.end == begin + 1 && c == '0')
                place.fill = '0';
            place.width = 10 * place.width + static_cast<size_t>(c - '0');
        }
        if (place.end < name.size() && name[place.end] == 'd') {
            ++place.end;
            return place;
        }
    }
    return {};
}

} // namespace

std::string WithFrameNumber(std::string_view name, size_t frame) {
    const std::string number = std::to_string(frame);
    std::string text;
    size_t from = 0;
    for (FramePlace place = FindFramePlace(name, 0); place.begin != std::string_view::npos;
         place = FindFramePlace(name, from)) {
        text += name.substr(from, place.begin - from);
        text += std::string(place.width - std::min(place.width, number.size()), place.fill) + number;
        from = place.end;
    }
    return text.append(name.substr(from));
}

FrameNames::FrameNames(const std::string &pattern, const std::string &what, const std::string &example)
    : pattern_(pattern) {
    const FramePlace first = FindFramePlace(pattern, 0);
    const bool hasNone = first.begin == std::string_view::npos;
    if (hasNone || FindFramePlace(pattern, first.end).begin != std::string_view::npos)
        throw Error("the {}'s name \"{}\" has {} for the number of a frame", what, pattern,
                    hasNone ? "no place" : "two places")
            .WithRemedy("write it as in {}", example);
}
std::string FrameNames::Of(size_t frame) const { return WithFrameNumber(pattern_, frame); }

std::vector<size_t> FrameNames::Existing() const {
    const std::filesystem::path folder = std::filesystem::path(pattern_).parent_path();
    const FramePlace place = FindFramePlace(pattern_, 0);
    std::vector<size_t> frames;
    std::error_code error;
    for (const auto &entry : std::filesystem::directory_iterator(folder.empty() ? "." : folder, error)) {
        const std::string name = (folder / entry.path().filename()).string();
        size_t frame = 0, at = place.begin;
        while (at < name.size() && name[at] == ' ')
            ++at;
        if (at >= name.size() ||
            std::from_chars(name.data() + at, name.data() + name.size(), frame).ec != std::errc{})
            continue;
        if (frame <= kMaxFrame && Of(frame) == name)
            frames.push_back(frame);
    }
    std::sort(frames.begin(), frames.end());
    return frames;
}

FrameRange ParseFrameRange(const std::string &text) {
    FrameRange range;
    const auto bad = [&](const char *what) {
        return Error("--frames \"{}\" {}", text, what)
            .WithRemedy("it is FIRST:LAST or FIRST:LAST:STEP, of whole numbers from 0 to {}, as in 0:95",
                        kMaxFrame);
    };
    const std::array<size_t *, 3> numbers = {&range.first, &range.last, &range.step};
    const char *p = text.data(), *const end = p + text.size();
    size_t count = 0;
    for (; count < numbers.size(); ++count) {
        const auto [after, error] = std::from_chars(p, end, *numbers[count]);
        if (error != std::errc{} || *numbers[count] > kMaxFrame)
            throw bad("is no range of frames");
        p = after;
        if (p == end)
            break;
        if (*p++ != ':')
            throw bad("is no range of frames");
    }
    if (count == 0 || count == numbers.size())
        throw bad("is no range of frames");
    if (range.last < range.first)
        throw bad("ends before it begins");
    if (range.step == 0)
        throw bad("has a step of 0");
    return range;
}

} // namespace cuticle
