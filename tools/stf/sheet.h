// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/vec.h"

#include <functional>
#include <memory>
#include <string>

namespace stf {

/// A drawing for a PNG: text, boxes, lines and pictures, on light grey. Places and sizes are in pixels from the top
/// left; colours are linear Rec.709. Throws std::runtime_error where it cannot be made or written.
class Sheet {
public:
    enum class Align { Left, Middle, Right };

    Sheet(int width, int height);
    ~Sheet();
    Sheet(Sheet&&) noexcept;
    Sheet& operator=(Sheet&&) noexcept;

    /// Text whose base line starts (or has its middle or end) at (x, y).
    void text(double x, double y, const std::string& text, double size = 12, Align align = Align::Left,
              bool bold = false);
    void textColor(const Rgb& color) { ink_ = color; }
    void fill(double x, double y, double width, double height, const Rgb& color);
    void frame(double x, double y, double width, double height);
    void line(double x0, double y0, double x1, double y1);
    /// A picture of columns x rows values, each a sharp rectangle, over the box given; row 0 on top.
    void picture(double x, double y, double width, double height, int columns, int rows,
                 const std::function<Rgb(int column, int row)>& value);
    /// A bar of a round length (1, 2 or 5 times a power of ten) of at most `width` pixels, with its length in mm or um.
    void scaleBar(double x, double y, double width, double mmPerPixel);

    /// Writes the PNG; beside the target first, so that no half of it is ever there.
    void write(const std::string& path) const;

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
    Rgb ink_{0.02f};
};

/// A length as people write it: "3.2 mm", "45 um", "infinite".
std::string lengthText(double mm);
/// The largest of 1, 2, 5 times a power of ten that is not above x > 0.
double roundLength(double x);

} // namespace stf
