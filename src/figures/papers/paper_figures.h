// The figures of the papers and of the book, one function each, named by paper and number. figure_table.cpp
// holds their captions and says how to add one.
#pragma once

#include "figures/figure.h"

#include <span>

namespace cuticle {

// Marschner et al. 2003
FigureData Marschner01(const FigureOptions &options);
FigureData Marschner03(const FigureOptions &options);
FigureData Marschner09(const FigureOptions &options);
FigureData Marschner16(const FigureOptions &options);
FigureData Marschner04(const FigureOptions &options);
FigureData Marschner05(const FigureOptions &options);
FigureData Marschner06(const FigureOptions &options);
FigureData Marschner07(const FigureOptions &options);
FigureData Marschner08(const FigureOptions &options);
FigureData Marschner10(const FigureOptions &options);

// d'Eon et al. 2011
FigureData Deon01(const FigureOptions &options);
FigureData Deon02(const FigureOptions &options);
FigureData Deon03(const FigureOptions &options);
FigureData Deon04(const FigureOptions &options);
FigureData Deon05(const FigureOptions &options);
FigureData Deon06(const FigureOptions &options);
FigureData Deon07(const FigureOptions &options);
FigureData Deon08(const FigureOptions &options);
FigureData Deon09(const FigureOptions &options);

// Pharr 2016
FigureData Pharr1_3(const FigureOptions &options);
FigureData Pharr1_4(const FigureOptions &options);
FigureData Pharr1_5(const FigureOptions &options);
FigureData Pharr1_6(const FigureOptions &options);
FigureData Pharr1_7(const FigureOptions &options);
FigureData Pharr1_11(const FigureOptions &options);
FigureData Pharr1_12(const FigureOptions &options);
FigureData Pharr1_13(const FigureOptions &options);
FigureData Pharr1_14(const FigureOptions &options);
FigureData Pharr1_9(const FigureOptions &options);
FigureData Pharr1_15(const FigureOptions &options);
FigureData Pharr1_16(const FigureOptions &options);
FigureData Pharr1_17(const FigureOptions &options);

// Petrovic et al. 2005
FigureData Petrovic1(const FigureOptions &options);
FigureData Petrovic2(const FigureOptions &options);
FigureData Petrovic3(const FigureOptions &options);
FigureData Petrovic4(const FigureOptions &options);
FigureData Petrovic5(const FigureOptions &options);
FigureData Petrovic6(const FigureOptions &options);

// Rendered: of the pictures of the figure's scenes
FigureData MeasureMarschner12(const FigureOptions &options, std::span<const FigurePicture> pictures);
FigureData MeasureMarschner13(const FigureOptions &options, std::span<const FigurePicture> pictures);
FigureData MeasureMarschner14(const FigureOptions &options, std::span<const FigurePicture> pictures);
FigureData MeasureMarschner15(const FigureOptions &options, std::span<const FigurePicture> pictures);
FigureData MeasureDeon10(const FigureOptions &options, std::span<const FigurePicture> pictures);
FigureData MeasureDeon11(const FigureOptions &options, std::span<const FigurePicture> pictures);
FigureData MeasureDeon12(const FigureOptions &options, std::span<const FigurePicture> pictures);
FigureData MeasurePharr1_1(const FigureOptions &options, std::span<const FigurePicture> pictures);
FigureData MeasurePharr1_2(const FigureOptions &options, std::span<const FigurePicture> pictures);
FigureData MeasurePharr1_8(const FigureOptions &options, std::span<const FigurePicture> pictures);
FigureData MeasurePharr1_10(const FigureOptions &options, std::span<const FigurePicture> pictures);
FigureData MeasurePharr1_18(const FigureOptions &options, std::span<const FigurePicture> pictures);
FigureData MeasurePharr1_19(const FigureOptions &options, std::span<const FigurePicture> pictures);
FigureData MeasurePharr1_20(const FigureOptions &options, std::span<const FigurePicture> pictures);

// The book's own
FigureData BookDemux(const FigureOptions &options);
FigureData BookMis(const FigureOptions &options);
FigureData BookPigments(const FigureOptions &options);
FigureData BookRecursion(const FigureOptions &options);
FigureData BookCapsule(const FigureOptions &options);

} // namespace cuticle
