#pragma once

#include <yaml.h>

#include <string>

namespace trefoil {

/// One document of a YAML file, as libyaml makes it.
class YamlDocument {
 public:
  /// @param path of the file, for errors
  /// @throws InputError, with the line, where `text` is no YAML
  YamlDocument(const std::string &path, const std::string &text);
  YamlDocument(const YamlDocument &) = delete;
  YamlDocument &operator=(const YamlDocument &) = delete;
  ~YamlDocument();

  /// Whether another document follows, after a line of three dashes.
  bool has_another();

  const yaml_node_t *root() { return yaml_document_get_root_node(&document_); }
  const yaml_node_t *node(int index) { return yaml_document_get_node(&document_, index); }

  /// Throws InputError that begins with the file and the node's line.
  [[noreturn]] void refuse(const yaml_node_t *where, const std::string &why) const;

 private:
  [[nodiscard]] std::string place(std::size_t line) const;
  [[nodiscard]] std::string problem_of_parser(const std::string &text) const;

  std::string path_;
  yaml_parser_t parser_{};
  yaml_document_t document_{};
};

/// A scalar's text in one line.
std::string text_of(const yaml_node_t *scalar);

/// Whether a node is there but empty: nothing, ~ or null.
bool is_null(const yaml_node_t *node);

}  // namespace trefoil
