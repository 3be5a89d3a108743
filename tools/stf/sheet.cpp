// SPDX-License-Identifier: Apache-2.0
#include "tools/stf/sheet.h"

#include "tools/srgb.h"
#include "tools/stfrecord/atomicFile.h"

#include <cairo.h>
#include <cstdint>
#include <cstdio>
#include <stdexcept>

namespace stf {

namespace {

constexpr float kPaper = 0.9f;

double encoded(float linear) {
    return srgbByte(linear) / 255.0;
}

void checkStatus(cairo_status_t status, const std::string& what) {
    if (status != CAIRO_STATUS_SUCCESS) {
        throw std::runtime_error(what + " (" + cairo_status_to_string(status) + ")");
    }
}

} // namespace

struct Sheet::Impl {
    cairo_surface_t* surface;
    cairo_t* context;

    Impl(int width, int height)
        : surface(cairo_image_surface_create(CAIRO_FORMAT_RGB24, width, height)), context(cairo_create(surface)) {}
    ~Impl() {
        cairo_destroy(context);
        cairo_surface_destroy(surface);
    }
    Impl(const Impl&) = delete;
    Impl& operator=(const Impl&) = delete;
    void color(const Rgb& c) const { cairo_set_source_rgb(context, encoded(c.x), encoded(c.y), encoded(c.z)); }
};

Sheet::Sheet(int width, int height) : impl_(std::make_unique<Impl>(width, height)) {
    checkStatus(cairo_status(impl_->context),
                "a sheet of " + std::to_string(width) + " x " + std::to_string(height) + " pixels cannot be made");
    fill(0, 0, width, height, Rgb(kPaper));
}

Sheet::~Sheet() = default;
Sheet::Sheet(Sheet&&) noexcept = default;
Sheet& Sheet::operator=(Sheet&&) noexcept = default;

void Sheet::text(double x, double y, const std::string& text, double size, Align align, bool bold) {
    cairo_t* const c = impl_->context;
    cairo_select_font_face(c, "sans-serif", CAIRO_FONT_SLANT_NORMAL,
                           bold ? CAIRO_FONT_WEIGHT_BOLD : CAIRO_FONT_WEIGHT_NORMAL);
    cairo_set_font_size(c, size);
    cairo_text_extents_t extents;
    cairo_text_extents(c, text.c_str(), &extents);
    const double share = align == Align::Left ? 0 : align == Align::Middle ? 0.5 : 1;
    impl_->color(ink_);
    cairo_move_to(c, x - share * extents.x_advance, y);
    cairo_show_text(c, text.c_str());
}

void Sheet::fill(double x, double y, double width, double height, const Rgb& color) {
    impl_->color(color);
    cairo_rectangle(impl_->context, x, y, width, height);
    cairo_fill(impl_->context);
}

void Sheet::frame(double x, double y, double width, double height) {
    impl_->color(ink_);
    cairo_set_line_width(impl_->context, 1);
    cairo_rectangle(impl_->context, std::floor(x) - 0.5, std::floor(y) - 0.5, std::ceil(width) + 1,
                    std::ceil(height) + 1);
    cairo_stroke(impl_->context);
}

void Sheet::line(double x0, double y0, double x1, double y1) {
    impl_->color(ink_);
    cairo_set_line_width(impl_->context, 1);
    cairo_move_to(impl_->context, x0, y0);
    cairo_line_to(impl_->context, x1, y1);
    cairo_stroke(impl_->context);
}

void Sheet::picture(double x, double y, double width, double height, int columns, int rows,
                    const std::function<Rgb(int, int)>& value) {
    cairo_surface_t* const image = cairo_image_surface_create(CAIRO_FORMAT_RGB24, columns, rows);
    checkStatus(cairo_surface_status(image),
                "a picture of " + std::to_string(columns) + " x " + std::to_string(rows) + " pixels cannot be made");
    unsigned char* const bytes = cairo_image_surface_get_data(image);
    const int stride = cairo_image_surface_get_stride(image);
    for (int row = 0; row < rows; ++row) {
        auto* const pixels = reinterpret_cast<std::uint32_t*>(bytes + std::ptrdiff_t(row) * stride);
        for (int column = 0; column < columns; ++column) {
            const Rgb c = value(column, row);
            pixels[column] = std::uint32_t(srgbByte(c.x)) << 16 | std::uint32_t(srgbByte(c.y)) << 8 | srgbByte(c.z);
        }
    }
    cairo_surface_mark_dirty(image);
    cairo_t* const c = impl_->context;
    cairo_save(c);
    cairo_translate(c, x, y);
    cairo_scale(c, width / columns, height / rows);
    cairo_set_source_surface(c, image, 0, 0);
    // Voxels stay sharp where they are larger than pixels, and are averaged where they are smaller.
    cairo_pattern_set_filter(cairo_get_source(c), width >= columns ? CAIRO_FILTER_NEAREST : CAIRO_FILTER_GOOD);
    cairo_rectangle(c, 0, 0, columns, rows);
    cairo_fill(c);
    cairo_restore(c);
    cairo_surface_destroy(image);
}

void Sheet::scaleBar(double x, double y, double width, double mmPerPixel) {
    const double mm = roundLength(width * mmPerPixel), pixels = mm / mmPerPixel;
    fill(x, y, pixels, 3, ink_);
    text(x + pixels + 6, y + 5, lengthText(mm), 11);
}

void Sheet::write(const std::string& path) const {
    stfrecord::writeAtomically(path, [&](const std::string& temporary) {
        checkStatus(cairo_surface_write_to_png(impl_->surface, temporary.c_str()), path + ": cannot be written");
    });
}

std::string lengthText(double mm) {
    if (!std::isfinite(mm)) {
        return "infinite";
    }
    const bool small = mm != 0 && std::abs(mm) < 0.1, large = mm >= 1000;
    char text[32];
    std::snprintf(text, sizeof text, "%.3g %s",
                  small   ? 1000 * mm
                  : large ? mm / 1000
                          : mm,
                  small   ? "um"
                  : large ? "m"
                          : "mm");
    return text;
}

double roundLength(double x) {
    const double power = std::pow(10, std::floor(std::log10(x)));
    const double digits = x / power * (1 + 1e-9);
    return power * (digits >= 5 ? 5 : digits >= 2 ? 2 : 1);
}

} // namespace stf
