// SPDX-License-Identifier: Apache-2.0
#include "stfLib/acquire/mesh_ply.h"

#include "stfLib/base/error.h"

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>

namespace stf {

namespace {

enum class Format { Text, Little, Big };

struct Type {
    int bytes = 0;
    bool isFloat = false, isSigned = false;
};

struct Property {
    std::string name;
    bool list = false;
    Type count, value;
};

struct Element {
    std::string name;
    std::uint64_t count = 0;
    std::vector<Property> properties;
};

const Type* typeOf(const std::string& name) {
    static const std::map<std::string, Type> types{
        {"char", {1, false, true}},    {"int8", {1, false, true}},    {"uchar", {1, false, false}},
        {"uint8", {1, false, false}},  {"short", {2, false, true}},   {"int16", {2, false, true}},
        {"ushort", {2, false, false}}, {"uint16", {2, false, false}}, {"int", {4, false, true}},
        {"int32", {4, false, true}},   {"uint", {4, false, false}},   {"uint32", {4, false, false}},
        {"float", {4, true, true}},    {"float32", {4, true, true}},  {"double", {8, true, true}},
        {"float64", {8, true, true}}};
    const auto at = types.find(name);
    return at == types.end() ? nullptr : &at->second;
}

class PlyReader {
public:
    explicit PlyReader(const std::string& path) : path_(path), in_(path, std::ios::binary) {
        if (!in_) {
            refuse("cannot be read");
        }
    }

    TriangleMesh read() {
        readHeader();
        for (const Element& e : elements_) {
            checkCount(e);
            for (std::uint64_t i = 0; i < e.count; ++i) {
                place_ = e.name + " " + std::to_string(i);
                readItem(e);
            }
        }
        for (const Vec3i& t : mesh_.triangles) {
            if (std::size_t(std::max({t.x, t.y, t.z})) >= mesh_.points.size()) {
                refuse("a face names vertex " + std::to_string(std::max({t.x, t.y, t.z})) + " of " +
                       std::to_string(mesh_.points.size()));
            }
        }
        if (mesh_.triangles.empty()) {
            refuse("holds no triangle");
        }
        return std::move(mesh_);
    }

private:
    [[noreturn]] void refuse(const std::string& what) const { throw Error(path_ + ": " + what); }

    void readHeader() {
        std::string line;
        const auto next = [&] {
            if (line.size() > 4096 || !std::getline(in_, line)) {
                refuse("is not a readable PLY file (its header has no end)");
            }
            while (!line.empty() && (line.back() == '\r' || line.back() == ' ')) {
                line.pop_back();
            }
        };
        next();
        if (line != "ply" && line != "PLY") {
            refuse("is not a readable PLY file (it does not begin with 'ply')");
        }
        bool formatKnown = false;
        for (next(); line != "end_header"; next()) {
            std::istringstream words(line);
            std::string word;
            words >> word;
            if (word == "format") {
                words >> word;
                formatKnown = word == "ascii" || word == "binary_little_endian" || word == "binary_big_endian";
                format_ = word == "ascii" ? Format::Text : word == "binary_big_endian" ? Format::Big : Format::Little;
            } else if (word == "element") {
                Element e;
                if (!(words >> e.name >> e.count)) {
                    refuse("is not a readable PLY file ('" + line + "')");
                }
                elements_.push_back(e);
            } else if (word == "property") {
                addProperty(line, words);
            }
        }
        if (!formatKnown) {
            refuse("is not a readable PLY file (no known format)");
        }
    }

    void addProperty(const std::string& line, std::istringstream& words) {
        Property p;
        std::string type, count;
        words >> type;
        p.list = type == "list";
        if (p.list) {
            words >> count >> type;
        }
        words >> p.name;
        const Type* const value = typeOf(type);
        const Type* const number = p.list ? typeOf(count) : value;
        if (!words || !value || !number || elements_.empty() || (p.list && number->isFloat)) {
            refuse("is not a readable PLY file ('" + line + "')");
        }
        p.value = *value;
        p.count = *number;
        elements_.back().properties.push_back(p);
    }

    /// Before anything is read: what the header promises must fit into what is left of the file.
    void checkCount(const Element& e) {
        double least = 0;
        for (const Property& p : e.properties) {
            least += format_ == Format::Text ? 2 : p.list ? p.count.bytes : p.value.bytes;
        }
        const double left = double(std::filesystem::file_size(path_)) - double(in_.tellg());
        if (double(e.count) * least > left + 1 || e.count > 0x7fffffff) {
            std::ostringstream s;
            s << "is cut off or damaged: it promises " << e.count << " of '" << e.name << "', what is left of it is "
              << left << " bytes";
            refuse(s.str());
        }
        if (e.name == "vertex") {
            mesh_.points.reserve(std::size_t(e.count));
        }
    }

    double number(const Type& type) {
        if (format_ == Format::Text) {
            // By the word: a stream does not read "nan".
            std::string word;
            if (!(in_ >> word)) {
                refuse("is cut off in " + place_);
            }
            char* end = nullptr;
            const double v = std::strtod(word.c_str(), &end);
            if (*end != 0) {
                refuse(place_ + " holds '" + word.substr(0, 20) + "'");
            }
            return v;
        }
        unsigned char bytes[8];
        if (!in_.read(reinterpret_cast<char*>(bytes), type.bytes)) {
            refuse("is cut off in " + place_);
        }
        std::uint64_t bits = 0;
        for (int i = 0; i < type.bytes; ++i) {
            bits |= std::uint64_t(bytes[format_ == Format::Big ? type.bytes - 1 - i : i]) << (8 * i);
        }
        if (type.isFloat && type.bytes == 4) {
            const std::uint32_t low = std::uint32_t(bits);
            float f;
            std::memcpy(&f, &low, sizeof f);
            return double(f);
        }
        if (type.isFloat) {
            double d;
            std::memcpy(&d, &bits, sizeof d);
            return d;
        }
        const int spare = 64 - 8 * type.bytes;
        return type.isSigned ? double(std::int64_t(bits << spare) >> spare) : double(bits);
    }

    void readItem(const Element& e) {
        Vec3d point;
        for (const Property& p : e.properties) {
            if (!p.list) {
                const double v = number(p.value);
                for (int k = 0; k < 3; ++k) {
                    point[k] = p.name == std::string(1, "xyz"[k]) ? v : point[k];
                }
                continue;
            }
            const double length = number(p.count);
            if (!(length >= 0 && length <= 1e6)) {
                refuse(place_ + " is a list of " + std::to_string(length));
            }
            const bool corners = e.name == "face" && (p.name == "vertex_indices" || p.name == "vertex_index");
            std::vector<int> list;
            for (int i = 0; i < int(length); ++i) {
                const double v = number(p.value);
                if (corners && !(v >= 0 && v <= 2147483647.0)) {
                    refuse(place_ + " names vertex " + std::to_string(v));
                }
                list.push_back(corners ? int(v) : 0);
            }
            if (corners) {
                addPolygon(mesh_, list);
            }
        }
        if (e.name == "vertex") {
            mesh_.points.push_back(point);
        }
    }

    const std::string path_;
    std::ifstream in_;
    Format format_ = Format::Text;
    std::vector<Element> elements_;
    std::string place_;
    TriangleMesh mesh_;
};

} // namespace

TriangleMesh readPly(const std::string& path) {
    return PlyReader(path).read();
}

} // namespace stf
