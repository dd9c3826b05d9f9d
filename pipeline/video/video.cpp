#include "pipeline/video/video.hpp"

#include <fmt/format.h>

#include "pipeline/export/render.hpp"
#include "pipeline/files/whole_file.hpp"
#include "pipeline/on_demand/vtk.hpp"
#include "process/on_demand.hpp"
#include "process/program_pipe.hpp"

namespace borelli {
namespace {

/// ffmpeg packs raw frames from its standard input: H.264 with 4:2:0 colours, which all browsers play.
std::vector<std::string> ffmpeg_words(const VideoOptions& options, const std::string& path) {
  return {"ffmpeg",
          "-nostdin",
          "-hide_banner",
          "-loglevel",
          "error",
          "-y",  //
          "-f",
          "rawvideo",
          "-pixel_format",
          "rgb24",
          "-video_size",
          fmt::format("{}x{}", options.width, options.height),
          "-framerate",
          fmt::format("{:.10g}", options.rate),
          "-i",
          "pipe:0",  //
          "-vf",
          "vflip,scale=out_color_matrix=bt709:out_range=tv",
          "-c:v",
          "libx264",
          "-preset",
          "medium",
          "-crf",
          "18",
          "-pix_fmt",
          "yuv420p",
          "-colorspace",
          "bt709",
          "-color_primaries",
          "bt709",
          "-color_trc",
          "bt709",
          "-color_range",
          "tv",
          "-movflags",
          "+faststart",
          "-f",
          "mp4",
          path};
}

}  // namespace

Result<void> check_video(const VideoOptions& options) {
  for (const int pixels : {options.width, options.height})
    if (pixels < 16 || pixels > 8192 || pixels % 2 != 0)
      return bad_use(fmt::format("video size {}x{}", options.width, options.height),
                     "must have an even width and height, from 16 to 8192 pixels");
  if (auto fine = program_is_there("ffmpeg", "ffmpeg"); !fine)
    return failure("video", "needs ffmpeg, which " + fine.error().what);
  return can_draw();
}

Result<std::size_t> write_video(const std::filesystem::path& path, const MovingBody& body,
                                const VideoOptions& options, const std::function<bool(double)>& progress) {
  if (auto fine = check_video(options); !fine) return tl::unexpected(fine.error());
  const auto film = film_of(body, options);
  if (!film) return tl::unexpected(film.error());
  const auto vtk = on_demand<VtkFunctions>();
  if (!vtk) return tl::unexpected(vtk.error());
  const auto done = write_whole(path, [&](const std::filesystem::path& beside) -> Result<void> {
    auto ffmpeg = ProgramPipe::start(ffmpeg_words(options, beside.string()));
    if (!ffmpeg) return tl::unexpected(ffmpeg.error());
    std::size_t taken = 0;
    const auto take = [&](std::span<const std::uint8_t> pixels) -> Result<void> {
      if (auto written = ffmpeg->write(pixels); !written) return written;
      ++taken;
      if (progress && !progress(double(taken) / double(film->frames)))
        return failure(path.string(), "the video was stopped");
      return {};
    };
    auto drawn = (*vtk)->draw_film(film->set, film->frames, film->frame, take);
    return drawn ? ffmpeg->finish() : drawn;
  });
  if (!done) return tl::unexpected(done.error());
  return film->frames;
}

}  // namespace borelli
