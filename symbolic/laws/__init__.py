"""Force laws of a wheel, one file each: every module without a leading underscore is one, its class called as the file.

Files in the folders that the environment variable SOFTSOIL_LAWS names belong to them.
"""

from softsoil.files.own_modules import LAWS, own_folders

__path__ = [*__path__, *own_folders(LAWS)]
