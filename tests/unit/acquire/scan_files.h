// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/acquire/scan.h"

#include <cstring>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

namespace stf::test {

/// A file written byte by byte.
class Bytes {
public:
    Bytes& text(const std::string& t) { return data_ += t, *this; }
    template<class T>
    Bytes& value(T v, bool bigEndian = false) {
        std::string bytes(sizeof(T), 0);
        std::memcpy(bytes.data(), &v, sizeof(T));
        data_ += bigEndian ? std::string(bytes.rbegin(), bytes.rend()) : bytes;
        return *this;
    }
    Bytes& pad(std::size_t size, char with = 0) {
        data_.resize(std::max(size, data_.size()), with);
        return *this;
    }
    std::size_t size() const { return data_.size(); }
    const std::string& data() const { return data_; }
    void write(const std::string& path, std::size_t leaveOut = 0) const {
        std::ofstream(path, std::ios::binary).write(data_.data(), std::streamsize(data_.size() - leaveOut));
    }

private:
    std::string data_;
};

/// A ball of value 200 in 50, with another value for each voxel so that no mistake of order goes unseen.
inline Scan ballScan(const Vec3i& size, const Vec3d& spacing) {
    Scan s{size, spacing, {}};
    const Vec3d middle = Vec3d(size) * spacing * 0.5;
    for (int z = 0; z < size.z; ++z) {
        for (int y = 0; y < size.y; ++y) {
            for (int x = 0; x < size.x; ++x) {
                const Vec3d p = Vec3d(x + 0.5, y + 0.5, z + 0.5) * spacing - middle;
                s.values.push_back((length(p) < 0.4 * minComponent(middle) * 2 ? 200.0f : 50.0f) +
                                   float((x + 2 * y + 3 * z) % 7));
            }
        }
    }
    return s;
}

template<class T>
void addValues(Bytes& bytes, const Scan& s, bool bigEndian = false) {
    for (const float v : s.values) {
        bytes.value(T(v), bigEndian);
    }
}

inline Bytes inrFile(const Scan& s, const std::string& type = "unsigned fixed", int bits = 8,
                     const std::string& cpu = "decm") {
    std::ostringstream h;
    h << "#INRIMAGE-4#{\nXDIM=" << s.size.x << "\nYDIM=" << s.size.y << "\nZDIM=" << s.size.z
      << "\nVDIM=1\nTYPE=" << type << "\nPIXSIZE=" << bits << " bits\nCPU=" << cpu << "\nVX=" << s.spacingMm.x
      << "\nVY=" << s.spacingMm.y << "\nVZ=" << s.spacingMm.z << "\n";
    Bytes b;
    b.text(h.str()).pad(252, '\n').text("##}\n");
    return b;
}

inline Bytes nrrdFile(const Scan& s, const std::string& type = "uint8", const std::string& more = "") {
    std::ostringstream h;
    h << "NRRD0004\ntype: " << type << "\ndimension: 3\nsizes: " << s.size.x << " " << s.size.y << " " << s.size.z
      << "\nspacings: " << s.spacingMm.x << " " << s.spacingMm.y << " " << s.spacingMm.z
      << "\nencoding: raw\nendian: little\n"
      << more << "\n";
    return Bytes().text(h.str());
}

inline Bytes metaFile(const Scan& s, const std::string& type = "MET_UCHAR", int channels = 1, bool bigEndian = false) {
    std::ostringstream h;
    h << "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = " << (bigEndian ? "True" : "False")
      << "\nElementSpacing = " << s.spacingMm.x << " " << s.spacingMm.y << " " << s.spacingMm.z
      << "\nDimSize = " << s.size.x << " " << s.size.y << " " << s.size.z << "\nElementNumberOfChannels = " << channels
      << "\nElementType = " << type << "\nElementDataFile = LOCAL\n";
    return Bytes().text(h.str());
}

/// NIfTI-1, one file; datatype 2 is uint8, 4 int16, 16 float32.
inline Bytes niftiFile(const Scan& s, int datatype = 2, int bits = 8, int volumes = 1, bool bigEndian = false) {
    Bytes b;
    b.value<std::int32_t>(348, bigEndian).pad(40);
    const int dims[8] = {volumes > 1 ? 4 : 3, s.size.x, s.size.y, s.size.z, volumes, 1, 1, 1};
    for (const int d : dims) {
        b.value<std::int16_t>(std::int16_t(d), bigEndian);
    }
    b.pad(70).value<std::int16_t>(std::int16_t(datatype), bigEndian).value<std::int16_t>(std::int16_t(bits), bigEndian);
    b.pad(76);
    const double spacing[8] = {1, s.spacingMm.x, s.spacingMm.y, s.spacingMm.z, 0, 0, 0, 0};
    for (const double d : spacing) {
        b.value<float>(float(d), bigEndian);
    }
    b.value<float>(352, bigEndian).value<float>(1, bigEndian).value<float>(0, bigEndian);
    b.pad(123).value<char>(2); // mm
    return b.pad(344).text("n+1").pad(352);
}

/// TIFF of 8-bit pages without compression; `channels` values per pixel.
inline Bytes tiffFile(const Scan& s, int firstLayer, int layers, int channels = 1) {
    const std::size_t voxels = std::size_t(s.size.x) * std::size_t(s.size.y), entries = 10;
    const std::size_t directory = 2 + 12 * entries + 4, page = voxels * std::size_t(channels);
    Bytes b;
    b.text("II").value<std::uint16_t>(42).value<std::uint32_t>(8);
    for (int k = 0; k < layers; ++k) {
        const std::size_t pixels = b.size() + directory;
        b.value<std::uint16_t>(std::uint16_t(entries));
        const auto entry = [&](int tag, int type, std::size_t value) {
            b.value<std::uint16_t>(std::uint16_t(tag)).value<std::uint16_t>(std::uint16_t(type));
            b.value<std::uint32_t>(1).value<std::uint32_t>(std::uint32_t(value));
        };
        entry(256, 4, std::size_t(s.size.x));
        entry(257, 4, std::size_t(s.size.y));
        entry(258, 3, 8);
        entry(259, 3, 1);
        entry(262, 3, channels == 3 ? 2 : 1);
        entry(273, 4, pixels);
        entry(277, 3, std::size_t(channels));
        entry(278, 4, std::size_t(s.size.y));
        entry(279, 4, page);
        entry(284, 3, 1);
        b.value<std::uint32_t>(std::uint32_t(k + 1 < layers ? pixels + page : 0));
        for (std::size_t i = 0; i < voxels; ++i) {
            const float v = s.values[std::size_t(firstLayer + k) * voxels + i];
            b.text(std::string(std::size_t(channels), char(static_cast<unsigned char>(v))));
        }
    }
    return b;
}

/// One DICOM slice of 16 bits, explicit little endian.
inline Bytes dicomSlice(const Scan& s, int layer, const std::string& series = "1.2.3") {
    Bytes meta, b;
    const auto element = [](Bytes& to, int group, int number, const char* vr, std::string value) {
        if (value.size() % 2) {
            value += std::string(vr) == "UI" ? '\0' : ' ';
        }
        to.value<std::uint16_t>(std::uint16_t(group)).value<std::uint16_t>(std::uint16_t(number)).text(vr);
        const std::string kind = vr;
        if (kind == "OW" || kind == "OB") {
            to.value<std::uint16_t>(0).value<std::uint32_t>(std::uint32_t(value.size()));
        } else {
            to.value<std::uint16_t>(std::uint16_t(value.size()));
        }
        to.text(value);
    };
    const auto us = [](int v) { return Bytes().value<std::uint16_t>(std::uint16_t(v)).data(); };
    const auto number = [](double v) {
        std::ostringstream t;
        t << v;
        return t.str();
    };
    const std::string ct = "1.2.840.10008.5.1.4.1.1.2", instance = series + ".9." + std::to_string(layer + 1);
    element(meta, 2, 1, "OB", std::string("\0\1", 2));
    element(meta, 2, 2, "UI", ct);
    element(meta, 2, 3, "UI", instance);
    element(meta, 2, 0x10, "UI", "1.2.840.10008.1.2.1");
    element(meta, 2, 0x12, "UI", "1.2.3.4");
    b.pad(128).text("DICM");
    element(b, 2, 0, "UL", Bytes().value<std::uint32_t>(std::uint32_t(meta.size())).data());
    b.text(meta.data());
    element(b, 8, 0x16, "UI", ct);
    element(b, 8, 0x18, "UI", instance);
    element(b, 8, 0x60, "CS", "CT");
    element(b, 0x18, 0x50, "DS", number(s.spacingMm.z));
    element(b, 0x20, 0xd, "UI", "1.2.3.5");
    element(b, 0x20, 0xe, "UI", series);
    element(b, 0x20, 0x13, "IS", std::to_string(layer + 1));
    element(b, 0x20, 0x32, "DS", "0\\0\\" + number(layer * s.spacingMm.z));
    element(b, 0x20, 0x37, "DS", "1\\0\\0\\0\\1\\0");
    element(b, 0x28, 2, "US", us(1));
    element(b, 0x28, 4, "CS", "MONOCHROME2");
    element(b, 0x28, 0x10, "US", us(s.size.y));
    element(b, 0x28, 0x11, "US", us(s.size.x));
    element(b, 0x28, 0x30, "DS", number(s.spacingMm.y) + "\\" + number(s.spacingMm.x));
    element(b, 0x28, 0x100, "US", us(16));
    element(b, 0x28, 0x101, "US", us(16));
    element(b, 0x28, 0x102, "US", us(15));
    element(b, 0x28, 0x103, "US", us(0));
    element(b, 0x28, 0x1052, "DS", "-1000");
    element(b, 0x28, 0x1053, "DS", "2");
    Bytes pixels;
    for (int i = 0; i < s.size.x * s.size.y; ++i) {
        pixels.value<std::uint16_t>(std::uint16_t(
            s.values[std::size_t(layer) * std::size_t(s.size.x) * std::size_t(s.size.y) + std::size_t(i)]));
    }
    element(b, 0x7fe0, 0x10, "OW", pixels.data());
    return b;
}

} // namespace stf::test
