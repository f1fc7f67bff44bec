#pragma once

namespace trefoil {

/// A host's function and its context.
template <class Function>
struct Callback {
  Function function = nullptr;
  void *context = nullptr;
  explicit operator bool() const { return function != nullptr; }
};

}  // namespace trefoil
