// SPDX-License-Identifier: Apache-2.0
#include "tools/stf/materials_sheet.h"

#include "stfLib/optics/semi_infinite.h"
#include "tools/stf/sheet.h"

#include <cmath>

namespace stf {

namespace {

constexpr int kColumns = 4, kCell = 230, kPatch = 92, kTop = 74, kHeight = 138;
constexpr double kShownMm = 10; // width of a swatch

// Light that comes out beside the edge of a half-plane of light, as a share of that far inside it: one exponential of
// the diffusion length, the far form of diffusing light, with the edge softened by a mean free path.
double beyondEdge(double mm, double diffusionLength) {
    if (!std::isfinite(diffusionLength)) {
        return 1;
    }
    const double x = mm / diffusionLength;
    return x > 0 ? 0.5 * std::exp(-x) : 1 - 0.5 * std::exp(x);
}

} // namespace

MaterialRow rowOf(const std::string& name, const Material& m) {
    MaterialRow row;
    row.name = name;
    row.material = m;
    for (int c = 0; c < 3; ++c) {
        const double total = m.extinction()[c];
        row.albedo[c] = total > 0 ? m.sigmaS[c] / total : 0.0;
    }
    row.reflectance = diffuseReflectance(m);
    row.meanFreePathMm = meanFreePathMm(m);
    row.diffusionLengthMm = diffusionLengthMm(m);
    return row;
}

void writeMaterialsSheet(const std::vector<MaterialRow>& rows, const std::string& path) {
    const int count = int(rows.size()), lines = (count + kColumns - 1) / kColumns;
    Sheet sheet(kColumns * kCell + 24, kTop + lines * kHeight + 8);
    sheet.text(16, 28, "Materials", 18, Sheet::Align::Left, true);
    sheet.text(16, 48,
               "Left: diffuse reflectance of a deep medium. Right: light beside the edge of a lit half-plane (in "
               "the middle), 10 mm across.");
    sheet.scaleBar(16, 58, kPatch, kShownMm / kPatch);
    for (int i = 0; i < count; ++i) {
        const MaterialRow& row = rows[std::size_t(i)];
        const double x = 16 + i % kColumns * kCell, y = kTop + 8 + i / kColumns * kHeight;
        const Rgb color(row.reflectance);
        sheet.fill(x, y, kPatch, kPatch, color);
        sheet.picture(x + kPatch + 6, y, kPatch, kPatch, kPatch, 1, [&](int column, int) {
            const double mm = (column + 0.5 - kPatch / 2) * kShownMm / kPatch;
            Rgb light;
            for (int c = 0; c < 3; ++c) {
                light[c] = color[c] * float(beyondEdge(mm, row.diffusionLengthMm[c]));
            }
            return light;
        });
        sheet.frame(x, y, kPatch, kPatch);
        sheet.frame(x + kPatch + 6, y, kPatch, kPatch);
        sheet.text(x, y + kPatch + 14, row.material.name, 12, Sheet::Align::Left, true);
        const Vec3d length = row.diffusionLengthMm;
        sheet.text(x, y + kPatch + 28,
                   lengthText(length.x) + " / " + lengthText(length.y) + " / " + lengthText(length.z), 10);
    }
    sheet.write(path);
}

} // namespace stf
