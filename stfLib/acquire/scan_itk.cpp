// SPDX-License-Identifier: Apache-2.0
#include "stfLib/acquire/scan_itk.h"

#include "stfLib/acquire/nifti_length.h"
#include "stfLib/acquire/scan_byte_order.h"

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <csignal>
#include <fcntl.h>
#include <filesystem>
#include <functional>
#include <itkGDCMImageIO.h>
#include <itkGDCMSeriesFileNames.h>
#include <itkMetaImageIO.h>
#include <itkNiftiImageIO.h>
#include <itkNrrdImageIO.h>
#include <itkTIFFImageIO.h>
#include <sstream>
#include <sys/wait.h>
#include <type_traits>
#include <unistd.h>

namespace stf {

namespace {

namespace fs = std::filesystem;

std::string lower(std::string text) {
    std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return char(std::tolower(c)); });
    return text;
}

bool isTiff(const fs::path& path) {
    const std::string e = lower(path.extension().string());
    return e == ".tif" || e == ".tiff";
}

// What went wrong, from the many words of ITK and the libraries below it: without ITK's class and address, the file's
// name and the chain of functions that noticed.
std::string reasonOf(const itk::ExceptionObject& e, const std::string& path) {
    std::string text = e.GetDescription();
    const std::size_t last = text.rfind("[nrrd] ");
    const std::size_t object = text.find("): ");
    if (last != std::string::npos) {
        text = text.substr(last + 7);
    } else if (text.find("(0x") < object && object != std::string::npos) {
        text = text.substr(object + 3);
    }
    for (std::size_t at = text.find(path); at != std::string::npos; at = text.find(path)) {
        text.replace(at, path.size(), "the file");
    }
    std::replace(text.begin(), text.end(), '\n', ' ');
    while (!text.empty() && text.back() == ' ') {
        text.pop_back();
    }
    return text.empty() ? "no reason given" : text;
}

// The libraries below ITK write to the error stream what their exceptions say again; MetaIO's says the only word of a
// file that ends early.
class QuietErrors {
public:
    QuietErrors() : before_(std::cerr.rdbuf(text_.rdbuf())), stream_(::dup(2)) {
        itk::Object::SetGlobalWarningDisplay(false);
        const int nothing = ::open("/dev/null", O_WRONLY); // libtiff and niftilib write past std::cerr
        ::dup2(nothing, 2);
        ::close(nothing);
    }
    ~QuietErrors() {
        ::dup2(stream_, 2);
        ::close(stream_);
        std::cerr.rdbuf(before_);
    }
    QuietErrors(const QuietErrors&) = delete;
    QuietErrors& operator=(const QuietErrors&) = delete;
    bool tell(const char* words) const { return text_.str().find(words) != std::string::npos; }

private:
    std::ostringstream text_;
    std::streambuf* before_;
    int stream_;
};

template<class F>
auto withItk(const std::string& path, F f) -> decltype(f()) {
    const QuietErrors quiet;
    try {
        if constexpr (std::is_void_v<decltype(f())>) {
            f();
        } else {
            auto result = f();
            if (quiet.tell("not read completely")) {
                throw Error("ends before its last voxel");
            }
            return result;
        }
    } catch (const itk::ExceptionObject& e) {
        throw Error("cannot be read: " + reasonOf(e, path));
    } catch (const std::bad_alloc&) {
        throw Error("cannot be read: it asks for more memory than there is");
    }
}

// Damaged DICOM ends the process in an assertion of the library that reads it: another process tries first.
template<class F>
void tryApart(F f) {
    const pid_t child = ::fork();
    if (child == 0) {
        const int nothing = ::open("/dev/null", O_WRONLY);
        ::dup2(nothing, 2);
        std::signal(SIGABRT, SIG_DFL);
        try {
            f();
        } catch (...) { // told by this process, when it does the same
        }
        ::_exit(0);
    }
    int status = 0;
    while (child > 0 && ::waitpid(child, &status, 0) < 0 && errno == EINTR) {
    }
    if (child > 0 && WIFSIGNALED(status)) {
        throw Error("is damaged: its reader (GDCM) gave up");
    }
}

using Component = itk::ImageIOBase::IOComponentEnum;

ScanType typeOf(Component c) {
    switch (c) {
    case Component::UCHAR:
        return ScanType::UInt8;
    case Component::CHAR:
        return ScanType::Int8;
    case Component::USHORT:
        return ScanType::UInt16;
    case Component::SHORT:
        return ScanType::Int16;
    case Component::UINT:
        return ScanType::UInt32;
    case Component::INT:
        return ScanType::Int32;
    case Component::FLOAT:
        return ScanType::Float32;
    case Component::DOUBLE:
        return ScanType::Float64;
    default:
        throw Error("holds voxels of type " + itk::ImageIOBase::GetComponentTypeAsString(c) +
                    ", which this program does not read");
    }
}

struct Format {
    const char* name;
    std::function<itk::ImageIOBase::Pointer()> make;
};

template<class Io>
Format format(const char* name) {
    return {name, [] { return itk::ImageIOBase::Pointer(Io::New()); }};
}

constexpr std::size_t kNifti = 0, kDicom = 4;

// In the order in which an unknown file is asked.
const std::vector<Format>& formats() {
    static const std::vector<Format> all{format<itk::NiftiImageIO>("NIfTI"), format<itk::NrrdImageIO>("NRRD"),
                                         format<itk::MetaImageIO>("MetaImage"), format<itk::TIFFImageIO>("TIFF"),
                                         format<itk::GDCMImageIO>("DICOM")};
    return all;
}

const Format& formatOf(const std::string& path) {
    const std::string name = lower(fs::path(path).filename().string());
    const auto ends = [&](const char* e) {
        const std::string ending(e);
        return name.size() > ending.size() && name.compare(name.size() - ending.size(), ending.size(), ending) == 0;
    };
    const auto& all = formats();
    if (ends(".nii") || ends(".nii.gz") || ends(".hdr") || ends(".img") || ends(".img.gz")) {
        return all[0];
    }
    if (ends(".nrrd") || ends(".nhdr")) {
        return all[1];
    }
    if (ends(".mha") || ends(".mhd")) {
        return all[2];
    }
    if (ends(".tif") || ends(".tiff")) {
        return all[3];
    }
    if (ends(".dcm")) {
        return all[kDicom];
    }
    tryApart([&] { withItk(path, [&] { return all[kDicom].make()->CanReadFile(path.c_str()); }); });
    for (const Format& f : all) {
        if (withItk(path, [&] { return f.make()->CanReadFile(path.c_str()); })) {
            return f;
        }
    }
    throw Error("is no scan that this program reads (INR, NIfTI, NRRD, MetaImage, TIFF, DICOM, or raw with --dims and "
                "--type)");
}

// Opens a file's header. A unit of one value per voxel.
itk::ImageIOBase::Pointer readInformation(const std::string& path, const Format& f) {
    const auto open = [&] {
        const itk::ImageIOBase::Pointer io = f.make();
        if (!io->CanReadFile(path.c_str())) {
            throw Error(std::string("is no ") + f.name + " file, or its header is damaged");
        }
        io->SetFileName(path);
        io->ReadImageInformation();
        if (io->GetNumberOfComponents() != 1) {
            throw Error("holds " + std::to_string(io->GetNumberOfComponents()) + " values per voxel (" +
                        itk::ImageIOBase::GetPixelTypeAsString(io->GetPixelType()) +
                        "); a scan has one: convert it to grey first");
        }
        return io;
    };
    if (&f == &formats()[kDicom]) {
        tryApart([&] { withItk(path, open); });
    }
    return withItk(path, open);
}

ScanHeader headerOf(const itk::ImageIOBase& io, const Format& f) {
    ScanHeader h;
    h.format = f.name;
    h.type = typeOf(io.GetComponentType());
    h.size = Vec3i(1);
    const unsigned dimensions = io.GetNumberOfDimensions();
    for (unsigned a = 0; a < dimensions; ++a) {
        const std::uint64_t n = io.GetDimensions(a);
        if (n > 2147483647u) {
            throw Error("a scan of " + std::to_string(n) + " voxels along axis " + std::to_string(a) + " cannot be");
        }
        if (a < 3) {
            h.size[int(a)] = int(n);
            h.spacingMm[int(a)] = io.GetSpacing(a);
        } else if (n != 1) {
            throw Error("holds " + std::to_string(n) + " volumes (axis " + std::to_string(a + 1) +
                        "); a scan is one: take one of them out first");
        }
    }
    // TIFF knows no distance of pages and often none of pixels, NRRD may do without; ITK then says 1.
    const std::string name = f.name;
    h.spacingKnown = (name != "TIFF" && name != "NRRD") || h.spacingMm != Vec3d(1.0);
    return h;
}

// Reads a part of an opened file, whose format may have two dimensions or three.
std::vector<unsigned char> readRegion(const std::string& path, itk::ImageIOBase& io, const VoxelBox& box) {
    const unsigned dimensions = io.GetNumberOfDimensions();
    itk::ImageIORegion region(dimensions);
    std::size_t bytes = io.GetComponentSize();
    for (unsigned a = 0; a < dimensions; ++a) {
        const int lo = a < 3 ? box.lo[int(a)] : 0, hi = a < 3 ? box.hi[int(a)] : 1;
        region.SetIndex(a, lo);
        region.SetSize(a, itk::SizeValueType(hi - lo));
        bytes *= std::size_t(hi - lo);
    }
    std::vector<unsigned char> buffer(bytes);
    io.SetIORegion(region);
    return withItk(path, [&] {
        io.Read(buffer.data());
        return std::move(buffer);
    });
}

void copyPart(const std::vector<unsigned char>& buffer, ScanType type, const VoxelBox& held, const VoxelBox& box,
              float* out) {
    const Vec3i from = held.size(), size = box.size();
    for (int z = 0; z < size.z; ++z) {
        for (int y = 0; y < size.y; ++y) {
            const Vec3i at = box.lo + Vec3i(0, y, z) - held.lo;
            const std::size_t voxel =
                std::size_t(at.x) + std::size_t(from.x) * (std::size_t(at.y) + std::size_t(from.y) * std::size_t(at.z));
            decodeValues(buffer.data() + voxel * bytesOf(type), type, false, std::size_t(size.x),
                         out + std::size_t(size.x) * (std::size_t(y) + std::size_t(size.y) * std::size_t(z)));
        }
    }
}

// Byte order is the header's word, which may be wrong where a text header describes a file of raw values.
void checkByteOrder(const std::vector<unsigned char>& buffer, ScanType type, const Vec3i& size) {
    const std::size_t layer = std::size_t(size.x) * std::size_t(size.y) * bytesOf(type);
    if (looksByteSwapped(buffer.data() + std::size_t(size.z / 2) * layer, type, false, std::size_t(size.x),
                         std::size_t(size.y))) {
        throw Error("voxels look like " + std::string(nameOf(type)) + " in the other byte order than the header says");
    }
}

class ItkFile : public ScanReader {
public:
    explicit ItkFile(const std::string& path) : path_(path), format_(formatOf(path)) {
        const itk::ImageIOBase::Pointer io = readInformation(path, format_);
        header_ = headerOf(*io, format_);
        inParts_ = io->CanStreamRead();
    }

    std::uint64_t bufferBytes(const VoxelBox& box) const override {
        return held(box).voxelCount() * bytesOf(header_.type);
    }

    std::vector<float> read(const VoxelBox& box, Progress& progress) const override {
        progress.update("read", 0);
        std::vector<float> values(std::size_t(box.voxelCount()));
        try {
            if (&format_ == &formats()[kNifti]) {
                checkNiftiLength(path_);
            }
            const VoxelBox part = held(box);
            const itk::ImageIOBase::Pointer io = readInformation(path_, format_);
            const auto buffer = readRegion(path_, *io, part);
            checkByteOrder(buffer, header_.type, part.size());
            copyPart(buffer, header_.type, part, box, values.data());
        } catch (const Error& e) {
            throw Error(path_ + ": " + e.what());
        }
        progress.update("read", 1);
        return values;
    }

private:
    VoxelBox held(const VoxelBox& box) const { return inParts_ ? box : VoxelBox{Vec3i(0), header_.size}; }

    std::string path_;
    const Format& format_;
    bool inParts_ = false;
};

class SliceStack : public ScanReader {
public:
    SliceStack(std::vector<std::string> files, const Format& f, const ScanHeader& header)
        : files_(std::move(files)), format_(f) {
        header_ = header;
    }

    std::uint64_t bufferBytes(const VoxelBox&) const override {
        return std::uint64_t(header_.size.x) * std::uint64_t(header_.size.y) * bytesOf(header_.type);
    }

    std::vector<float> read(const VoxelBox& box, Progress& progress) const override {
        const Vec3i size = box.size();
        const std::size_t layer = std::size_t(size.x) * std::size_t(size.y);
        std::vector<float> values(std::size_t(box.voxelCount()));
        for (int z = box.lo.z; z < box.hi.z; ++z) {
            const std::string& path = files_[std::size_t(z)];
            try {
                const itk::ImageIOBase::Pointer io = readInformation(path, format_);
                const ScanHeader h = headerOf(*io, format_);
                if (h.size != Vec3i(header_.size.x, header_.size.y, 1)) {
                    throw Error("is " + sizeText(h.size) + " voxels, the first slice of the folder " +
                                sizeText({header_.size.x, header_.size.y, 1}));
                }
                const VoxelBox whole{Vec3i(0), h.size};
                const auto buffer = readRegion(path, *io, whole);
                if (z == (box.lo.z + box.hi.z) / 2) {
                    checkByteOrder(buffer, h.type, h.size);
                }
                copyPart(buffer, h.type, whole, {{box.lo.x, box.lo.y, 0}, {box.hi.x, box.hi.y, 1}},
                         values.data() + std::size_t(z - box.lo.z) * layer);
            } catch (const Error& e) {
                throw Error(path + ": " + e.what());
            }
            progress.update("read", double(z + 1 - box.lo.z) / size.z);
        }
        return values;
    }

private:
    std::vector<std::string> files_;
    const Format& format_;
};

// "slice2" before "slice10".
bool numbersFirst(const std::string& a, const std::string& b) {
    std::size_t i = 0, j = 0;
    const auto digit = [](char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; };
    while (i < a.size() && j < b.size()) {
        if (digit(a[i]) && digit(b[j])) {
            std::size_t p = i, q = j;
            while (p < a.size() && digit(a[p])) {
                ++p;
            }
            while (q < b.size() && digit(b[q])) {
                ++q;
            }
            std::string m = a.substr(i, p - i), n = b.substr(j, q - j);
            m.erase(0, std::min(m.find_first_not_of('0'), m.size()));
            n.erase(0, std::min(n.find_first_not_of('0'), n.size()));
            if (m.size() != n.size() || m != n) {
                return m.size() != n.size() ? m.size() < n.size() : m < n;
            }
            i = p;
            j = q;
        } else if (a[i] != b[j]) {
            return a[i] < b[j];
        } else {
            ++i;
            ++j;
        }
    }
    return a.size() - i < b.size() - j;
}

std::unique_ptr<ScanReader> openTiffFolder(const std::string& folder) {
    std::vector<std::string> files;
    for (const auto& entry : fs::directory_iterator(folder)) {
        if (entry.is_regular_file() && isTiff(entry.path())) {
            files.push_back(entry.path().string());
        }
    }
    if (files.empty()) {
        throw Error("the folder holds neither DICOM nor TIFF slices");
    }
    std::sort(files.begin(), files.end(), numbersFirst);
    const Format& f = formatOf(files[0]);
    ScanHeader header;
    try {
        header = headerOf(*readInformation(files[0], f), f);
    } catch (const Error& e) {
        throw Error(fs::path(files[0]).filename().string() + ": " + e.what());
    }
    if (header.size.z != 1) {
        throw Error(fs::path(files[0]).filename().string() + " holds " + std::to_string(header.size.z) +
                    " pages: give that file instead of its folder");
    }
    header.size.z = int(files.size());
    return std::make_unique<SliceStack>(std::move(files), f, header);
}

// Distance of the slices along their normal; tells where it is not even.
double sliceDistance(const std::vector<std::string>& files, const Format& f, const MessageSink& messages) {
    std::vector<double> depth;
    for (const std::string& file : files) {
        const itk::ImageIOBase::Pointer io = readInformation(file, f);
        const std::vector<double> normal = io->GetDirection(2);
        double d = 0;
        for (unsigned a = 0; a < 3; ++a) {
            d += normal[a] * io->GetOrigin(a);
        }
        depth.push_back(d);
    }
    const double mean = std::abs(depth.back() - depth.front()) / double(depth.size() - 1);
    if (!(mean > 0)) {
        return 0;
    }
    std::size_t odd = 0, first = 0;
    for (std::size_t i = 0; i + 1 < depth.size(); ++i) {
        if (std::abs(std::abs(depth[i + 1] - depth[i]) - mean) > 0.02 * mean) {
            first = odd == 0 ? i : first;
            ++odd;
        }
    }
    if (odd > 0) {
        std::ostringstream text;
        text << odd << " of " << depth.size() - 1 << " distances between slices differ from their mean, " << mean
             << " mm; the first is " << std::abs(depth[first + 1] - depth[first]) << " mm between "
             << fs::path(files[first]).filename().string() << " and " << fs::path(files[first + 1]).filename().string()
             << ": is a slice missing?";
        report(messages, Severity::Warning, text.str());
    }
    return mean;
}

} // namespace

std::unique_ptr<ScanReader> openItk(const std::string& path) {
    return std::make_unique<ItkFile>(path);
}

std::unique_ptr<ScanReader> openSlices(const std::string& folder, const std::string& series,
                                       const MessageSink& messages) {
    std::vector<std::string> uids, files;
    const auto list = [&] {
        const auto names = itk::GDCMSeriesFileNames::New();
        names->SetUseSeriesDetails(false);
        names->SetDirectory(folder);
        uids = names->GetSeriesUIDs();
        if (!uids.empty() && (uids.size() == 1 || !series.empty())) {
            files = names->GetFileNames(series.empty() ? uids[0] : series);
        }
    };
    tryApart([&] { withItk(folder, list); });
    withItk(folder, list);
    if (uids.empty()) {
        return openTiffFolder(folder);
    }
    if (files.empty()) {
        std::string known;
        for (const std::string& uid : uids) {
            known += (known.empty() ? "" : ", ") + uid;
        }
        throw Error((series.empty() ? "the folder holds " + std::to_string(uids.size()) + " DICOM series"
                                    : "the folder holds no DICOM series " + series) +
                    "; choose one with --series: " + known);
    }
    const Format& f = formats()[kDicom];
    ScanHeader header = headerOf(*readInformation(files[0], f), f);
    if (files.size() == 1) {
        return openItk(files[0]);
    }
    header.size.z = int(files.size());
    const double distance = sliceDistance(files, f, messages);
    if (distance > 0) {
        header.spacingMm.z = distance;
        header.spacingKnown = true;
    }
    return std::make_unique<SliceStack>(std::move(files), f, header);
}

} // namespace stf
