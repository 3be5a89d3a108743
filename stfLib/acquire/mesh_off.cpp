// SPDX-License-Identifier: Apache-2.0
#include "stfLib/acquire/mesh_off.h"

#include "stfLib/base/error.h"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

namespace stf {

namespace {

/// Lines with something on them, without comments.
class Lines {
public:
    explicit Lines(const std::string& path) : path_(path), in_(path) {}
    [[noreturn]] void refuse(const std::string& what) const { throw Error(path_ + ": " + what); }
    /// The next line, as words; `place` is what is missing where the file ends.
    std::istringstream& next(const std::string& place) {
        std::string line;
        while (std::getline(in_, line)) {
            line = line.substr(0, line.find('#'));
            if (line.find_first_not_of(" \t\r") != std::string::npos) {
                words_.clear();
                words_.str(line);
                return words_;
            }
        }
        refuse("is cut off: " + place + " is missing");
    }

private:
    const std::string path_;
    std::ifstream in_;
    std::istringstream words_;
};

double number(Lines& lines, std::istringstream& words, const std::string& place) {
    std::string word;
    words >> word;
    char* end = nullptr;
    const double v = std::strtod(word.c_str(), &end);
    if (word.empty() || *end != 0) {
        lines.refuse(word.empty() ? "is cut off or damaged in " + place
                                  : place + " holds '" + word.substr(0, 20) + "'");
    }
    return v;
}

} // namespace

TriangleMesh readOff(const std::string& path) {
    Lines lines(path);
    std::istringstream* words = &lines.next("its head");
    std::string head;
    *words >> head;
    std::string more;
    if (head.size() < 3 || head.size() > 8 || head.compare(head.size() - 3, 3, "OFF") != 0 ||
        head.find_first_of("4n") != std::string::npos) {
        lines.refuse("is not a readable OFF file (it does not begin with 'OFF')");
    }
    // The counts may stand beside the head.
    if (!(*words >> more)) {
        words = &lines.next("the number of its vertices");
        *words >> more;
    }
    char* end = nullptr;
    const double points = std::strtod(more.c_str(), &end), faces = *end ? -1 : number(lines, *words, "its counts");
    const double bytes = double(std::filesystem::file_size(path));
    // A vertex takes 6 bytes at least, so does a face.
    if (!(points >= 0 && faces >= 0) || 6 * (points + faces) > bytes + 6) {
        std::ostringstream s;
        s << "is cut off or damaged: it promises " << points << " vertices and " << faces << " faces in " << bytes
          << " bytes";
        lines.refuse(s.str());
    }
    TriangleMesh mesh;
    for (std::size_t i = 0; i < std::size_t(points); ++i) {
        const std::string place = "vertex " + std::to_string(i);
        std::istringstream& w = lines.next(place);
        const double x = number(lines, w, place), y = number(lines, w, place), z = number(lines, w, place);
        mesh.points.push_back({x, y, z});
    }
    for (std::size_t i = 0; i < std::size_t(faces); ++i) {
        const std::string place = "face " + std::to_string(i);
        std::istringstream& w = lines.next(place);
        const double count = number(lines, w, place);
        if (!(count >= 0 && count <= 1e6)) {
            lines.refuse(place + " has " + std::to_string(count) + " corners");
        }
        std::vector<int> corners;
        for (int k = 0; k < int(count); ++k) {
            const double v = number(lines, w, place);
            if (!(v >= 0 && v < points)) {
                std::ostringstream s;
                s << place << " names vertex " << v << " of " << points;
                lines.refuse(s.str());
            }
            corners.push_back(int(v));
        }
        addPolygon(mesh, corners);
    }
    if (mesh.triangles.empty()) {
        lines.refuse("holds no triangle");
    }
    return mesh;
}

} // namespace stf
