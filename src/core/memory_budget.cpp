#include "core/memory_budget.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <string_view>
#include <utility>

namespace cuticle {

namespace {

thread_local MemoryBudget *budgetOfThread = nullptr;

constexpr std::array<std::string_view, 5> kUnits{"bytes", "KB", "MB", "GB", "TB"};

} // namespace

void MemoryBudget::Claim(const std::string &what, uint64_t bytes, const FileLoc &loc) {
    const std::lock_guard lock(mutex_);
    claimed_ = bytes > UINT64_MAX - claimed_ ? UINT64_MAX : claimed_ + bytes;
    if (bytes > largest_) {
        largest_ = bytes;
        largestWhat_ = what;
        largestLoc_ = loc;
    }
    if (claimed_ <= limit_)
        return;
    const std::string place = largestLoc_.file ? " (" + largestLoc_.ToString() + ")" : "";
    throw Error(loc, "{} of memory would be needed, and --max-memory allows {}; most of it, {}, is for {}{}",
                ByteSizeText(claimed_), ByteSizeText(limit_), ByteSizeText(largest_), largestWhat_, place)
        .Finally();
}

MemoryBudgetScope::MemoryBudgetScope(MemoryBudget *budget) : outer_(std::exchange(budgetOfThread, budget)) {}
MemoryBudgetScope::~MemoryBudgetScope() { budgetOfThread = outer_; }

void ClaimMemory(const std::string &what, uint64_t bytes, const FileLoc &loc) {
    if (budgetOfThread) // an Error takes the place of the directive under way where it has none
        budgetOfThread->Claim(what, bytes, Error(loc, "").Place());
}
bool MemoryIsLimited() { return budgetOfThread != nullptr; }

uint64_t ParseByteSize(const std::string &text) {
    double number = 0;
    const char *end = text.data() + text.size();
    const auto [stop, status] = std::from_chars(text.data(), end, number);
    std::string unit(stop, end);
    if (unit.size() == 2 && (unit[1] == 'B' || unit[1] == 'b'))
        unit.pop_back();
    constexpr std::string_view kLetters = "bkmgt";
    const size_t power = unit.empty()      ? 0
                         : unit.size() > 1 ? kLetters.npos
                                           : kLetters.find(static_cast<char>(unit[0] | 0x20));
    if (status != std::errc() || power == kLetters.npos || !(number > 0 && number < 1e15))
        throw Error("\"{}\" is no size of memory", text).WithRemedy("write 4G, 512M or a number of bytes");
    for (size_t i = 0; i < power; ++i)
        number *= 1024;
    return static_cast<uint64_t>(std::min(number, 9e18));
}

std::string ByteSizeText(uint64_t bytes) {
    auto number = static_cast<double>(bytes);
    size_t unit = 0;
    while (number >= 1024 && unit + 1 < kUnits.size())
        number /= 1024, ++unit;
    return fmt::format("{:.{}f} {}", number, unit == 0 ? 0 : 1, kUnits[unit]);
}

} // namespace cuticle
