//> Define the table of fiber models
#include "fibers/models.h"

#include "core/check.h"

#include <algorithm>

namespace cuticle {

//> List the models
// To add a fiber model: write it (fibers/NAME.h and .cpp, a class for BxDFOf, see bxdf.h), state in a row
// (fibers/NAME_row.cpp) what its parameters are and how they become the model, and name the row here. Scenes,
// --hair-model, the manual, the laws, the atlas, the chart "models" and the benchmark read it from this
// table.
FiberModel ChiangRow();
FiberModel KajiyaKayRow();
FiberModel MarschnerRow();
FiberModel DEonRow();
FiberModel TabulatedRow();

namespace {
std::deque<FiberModel> &Table() {
    static std::deque<FiberModel> table = {ChiangRow(), KajiyaKayRow(), MarschnerRow(), DEonRow(),
                                           TabulatedRow()};
    return table;
}
} // namespace
//<

//> Find a row, add a row
const std::deque<FiberModel> &FiberModels() { return Table(); }

const FiberModel *FindFiberModel(std::string_view name) {
    for (const FiberModel &model : Table())
        if (model.name == name)
            return &model;
    return nullptr;
}

const FiberModel &AddFiberModel(FiberModel model) {
    if (FindFiberModel(model.name))
        throw Error("there is a fiber model \"{}\" already", model.name);
    const auto textures = [&model](std::string_view type) {
        return static_cast<size_t>(std::count_if(model.params.begin(), model.params.end(),
                                                 [&](const ParamInfo &p) { return p.type == type; }));
    };
    if (textures("float texture") > kMaxOwnNumbers || textures("spectrum texture") > kMaxOwnColors)
        throw Error("the fiber model \"{}\" has more textures of its own than {} numbers and {} colours",
                    model.name, kMaxOwnNumbers, kMaxOwnColors);
    return Table().emplace_back(std::move(model));
}

const ParamInfo *FiberModel::FindParam(std::string_view param) const {
    for (const ParamInfo &p : params)
        if (p.name == param)
            return &p;
    return nullptr;
}
//<

//> Find the slot of a texture
std::optional<size_t> FiberSettings::Slot(std::string_view name) const {
    if (!Has(name))
        return std::nullopt;
    const ParamInfo *row = model_.FindParam(name);
    CHECK(row) << "\"" << name << "\" is no parameter of the fiber model \"" << model_.name << "\"";
    size_t slot = 0; // rows of one type are numbered in their order
    for (const ParamInfo *p = model_.params.data(); p != row; ++p)
        slot += p->type == row->type ? 1 : 0;
    return slot;
}
//<

//> Read one of a few names, and one number for all
size_t FiberSettings::Choice(std::string_view name) const {
    const ParamInfo *row = model_.FindParam(name);
    CHECK(row && !row->choices.empty()) << "\"" << name << "\" has no choices";
    const std::string word = Word(name, row->choices.front());
    for (size_t i = 0; i < row->choices.size(); ++i)
        if (row->choices[i] == word)
            return i;
    throw ErrorAt(name, fmt::format("\"{}\" cannot be \"{}\". {}", name, word,
                                    Suggestion(word, row->choices.data(), row->choices.size())));
}
void FiberSettings::MustNotVary(std::string_view name) const {
    if (IsTexture(name))
        throw ErrorAt(name, fmt::format("the model \"{}\" needs one number for \"{}\", the same on the whole "
                                        "hair, not a texture",
                                        model_.name, name));
}
//<

//> Take values from a program
FiberValues::FiberValues(const FiberModel &model, const FiberInputs &at, std::vector<OwnValue> own)
    : FiberSettings(model), own_(std::move(own)), inputs_(at) {
    inputs_.numbers.fill(0);
    inputs_.colors.fill({0, 0, 0});
    for (const OwnValue &o : own_) {
        const ParamInfo *row = model.FindParam(o.name);
        if (!row)
            throw Error("the fiber model \"{}\" has no parameter \"{}\"", model.name, o.name);
        if (row->type == "float texture")
            inputs_.numbers[*Slot(o.name)] = std::get<float>(o.value);
        else if (row->type == "spectrum texture")
            inputs_.colors[*Slot(o.name)] = std::get<std::array<float, 3>>(o.value);
    }
}
const OwnValue *FiberValues::Find(std::string_view name) const {
    for (const OwnValue &o : own_)
        if (o.name == name)
            return &o;
    return nullptr;
}
float FiberValues::Number(std::string_view name, float otherwise) const {
    const OwnValue *o = Find(name);
    return o ? std::get<float>(o->value) : otherwise;
}
int FiberValues::Integer(std::string_view name, int otherwise) const {
    const OwnValue *o = Find(name);
    return o ? std::get<int>(o->value) : otherwise;
}
bool FiberValues::Flag(std::string_view name, bool otherwise) const {
    const OwnValue *o = Find(name);
    return o ? std::get<bool>(o->value) : otherwise;
}
std::string FiberValues::Word(std::string_view name, std::string_view otherwise) const {
    const OwnValue *o = Find(name);
    return std::string(o ? std::get<std::string_view>(o->value) : otherwise);
}
Error FiberValues::ErrorAt(std::string_view, const std::string &message) const {
    return Error("fiber model \"{}\": {}", model_.name, message);
}

PreparedFiber::PreparedFiber(const FiberModel &model, const FiberInputs &at,
                             const std::vector<OwnValue> &own) {
    const FiberValues values(model, at, own);
    inputs = values.AtOnePlace();
    maker = model.prepare(values);
}
//<

} // namespace cuticle
//<
