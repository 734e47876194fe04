#include "apps/batch/tasks.h"

#include <cstdio>
#include <utility>

#include "core/io/binary/npz_file.h"
#include "core/io/files/text_file.h"

namespace kinegraph {
namespace {

std::string Joined(const std::string& a, const std::string& b) {
  return a.empty() || b.empty() ? a + b : a + ";" + b;
}

void Add(std::vector<std::string>* arguments, const std::string& flag,
         const std::string& value) {
  if (!value.empty()) arguments->push_back("--" + flag + "=" + value);
}

// Flags of every command that tracks.
std::vector<std::string> TrackingArguments(
    const ManifestRecording& recording,
    const ManifestConfiguration& configuration) {
  std::vector<std::string> arguments;
  Add(&arguments, "cameras", recording.cameras);
  Add(&arguments, "detections", recording.detections);
  Add(&arguments, "config", configuration.config);
  // The recording's keys describe its data and come last.
  Add(&arguments, "set", Joined(configuration.set, recording.set));
  Add(&arguments, "mode", configuration.mode);
  Add(&arguments, "frames", recording.frames);
  return arguments;
}

TaskStep MakeStep(const std::string& command,
                  std::vector<std::string> arguments,
                  const std::string& output_flag, const std::string& output) {
  Add(&arguments, output_flag, output);
  return {command, std::move(arguments), output};
}

std::vector<TaskStep> StepsOf(const Manifest& manifest,
                              const ManifestRecording& recording,
                              const ManifestConfiguration& configuration) {
  const std::string tracks = "tracks.jsonl";
  const std::vector<std::string> tracking =
      TrackingArguments(recording, configuration);
  std::vector<TaskStep> steps = {MakeStep("track", tracking, "out", tracks)};
  const auto evaluate = [&](const std::string& protocol,
                            const std::string& output) {
    std::vector<std::string> arguments;
    Add(&arguments, "tracks", tracks);
    Add(&arguments, "ground_truth", recording.ground_truth);
    Add(&arguments, "protocol", protocol);
    Add(&arguments, "frames", recording.frames);
    steps.push_back(MakeStep("evaluate", arguments, "json", output));
  };
  if (!recording.ground_truth.empty()) {
    evaluate(recording.protocol, "evaluation.json");
    if (recording.protocol != "identity") evaluate("identity", "identity.json");
  }
  if (manifest.held_out) {
    std::vector<std::string> arguments = tracking;
    Add(&arguments, "protocol", "held_out_camera");
    steps.push_back(MakeStep("evaluate", arguments, "json", "held_out.json"));
  }
  if (manifest.compare) {
    steps.push_back(MakeStep("compare", tracking, "out", "compare"));
  }
  if (manifest.report) {
    std::vector<std::string> arguments;
    Add(&arguments, "tracks", tracks);
    Add(&arguments, "ground_truth", recording.ground_truth);
    steps.push_back(MakeStep("report", arguments, "out", "report.html"));
  }
  return steps;
}

// The checksum of a file's content; of a folder or pipe, nothing.
std::string ContentMark(const std::string& path) {
  if (path.empty() || !IsFile(path)) return path + "\n";
  char mark[16];
  std::snprintf(mark, sizeof(mark), "%08x", Crc32(ReadBytes(path)));
  return path + " " + mark + "\n";
}

}  // namespace

std::vector<Task> TasksOf(const Manifest& manifest) {
  std::vector<Task> tasks;
  for (const ManifestRecording& recording : manifest.recordings) {
    const std::string recording_marks =
        ContentMark(recording.cameras) + ContentMark(recording.ground_truth);
    for (const ManifestConfiguration& configuration : manifest.configurations) {
      Task task;
      task.recording = recording.name;
      task.configuration = configuration.name;
      task.steps = StepsOf(manifest, recording, configuration);
      std::string told = recording_marks + ContentMark(configuration.config);
      for (const TaskStep& step : task.steps) {
        told += step.command;
        for (const std::string& argument : step.arguments) {
          told += " " + argument;
        }
        told += "\n";
      }
      char mark[16];
      std::snprintf(mark, sizeof(mark), "%08x", Crc32(told));
      task.fingerprint = mark;
      tasks.push_back(std::move(task));
    }
  }
  return tasks;
}

}  // namespace kinegraph
