// The functions of onnxruntime's C interface that are used here, declared by ourselves: the
// interface is a table of pointers that only ever grows at its end (onnxruntime_c_api.h, "OrtApi"),
// and the official header comes only in packages of 150 MB. onnx_network_test.cpp compares the two
// where that header is installed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "fluxgs/error.h"

namespace fluxgs::networks::ort {

struct Status;
struct Env;
struct Session;
struct SessionOptions;
struct RunOptions;
struct MemoryInfo;
struct Value;
struct ShapeInfo;

/// The first that knows operator set 21, see kMaxOpset.
inline constexpr std::uint32_t kApiVersion = 18;

inline constexpr int kLogFatal = 4;      ///< OrtLoggingLevel
inline constexpr int kOptimizeAll = 99;  ///< GraphOptimizationLevel
inline constexpr int kDeviceAllocator = 0, kDefaultMemory = 0;
inline constexpr int kFloat = 1;  ///< ONNXTensorElementDataType

/// Return type of OrtGetApiBase().
struct ApiBase {
  const void* (*get_api)(std::uint32_t version);
  const char* (*get_version)();
};

/// Functions and their places in the table. All return null or a Status that says what failed.
struct Api {
  const char* (*error_message)(const Status*);
  Status* (*create_env)(int log_level, const char* id, Env**);
  Status* (*disable_telemetry)(const Env*);
  Status* (*create_session)(const Env*, const void* model, std::size_t bytes, const SessionOptions*,
                            Session**);
  Status* (*run)(Session*, const RunOptions*, const char* const* input_names,
                 const Value* const* inputs, std::size_t input_count,
                 const char* const* output_names, std::size_t output_count, Value** outputs);
  Status* (*create_options)(SessionOptions**);
  Status* (*disable_memory_pattern)(SessionOptions*);
  Status* (*disable_arena)(SessionOptions*);
  Status* (*set_optimization)(SessionOptions*, int level);
  Status* (*set_threads)(SessionOptions*, int count);
  Status* (*wrap_tensor)(const MemoryInfo*, void* data, std::size_t bytes,
                         const std::int64_t* shape, std::size_t rank, int type, Value**);
  Status* (*tensor_data)(Value*, void** data);
  Status* (*element_type)(const ShapeInfo*, int* type);
  Status* (*rank)(const ShapeInfo*, std::size_t* count);
  Status* (*dimensions)(const ShapeInfo*, std::int64_t* dims, std::size_t count);
  Status* (*shape_of)(const Value*, ShapeInfo**);
  Status* (*create_memory_info)(int allocator, int memory_type, MemoryInfo**);
  Status* (*add_config)(SessionOptions*, const char* key, const char* value);
  void (*release_status)(Status*);
  void (*release_memory_info)(MemoryInfo*);
  void (*release_session)(Session*);
  void (*release_value)(Value*);
  void (*release_shape)(ShapeInfo*);
  void (*release_options)(SessionOptions*);
};

/// Index of each of them in the table.
struct Slots {
  std::size_t error_message = 2, create_env = 3, disable_telemetry = 6, create_session = 8, run = 9,
              create_options = 10, disable_memory_pattern = 17, disable_arena = 19,
              set_optimization = 23, set_threads = 24, wrap_tensor = 49, tensor_data = 51,
              element_type = 60, rank = 61, dimensions = 62, shape_of = 65, create_memory_info = 69,
              release_status = 93, release_memory_info = 94, release_session = 95,
              release_value = 96, release_shape = 99, release_options = 100, add_config = 130;
};

/// The library, loaded and started. Lives until the program ends.
struct Runtime {
  std::string version, path;
  Api api;
  Env* env = nullptr;
};

/// Loads the library on the first call, see fluxgs/networks/onnx_runtime.h.
Expected<const Runtime*> load_runtime();

/// An error with the first line of what onnxruntime says, if it says anything.
Expected<void> check(const Api& api, Status* status, const char* what);

}  // namespace fluxgs::networks::ort
