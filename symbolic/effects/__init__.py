"""Physical effects that a nominal model lacks, one file each: every module without a leading underscore is one.

Files in the folders that the environment variable SOFTSOIL_EFFECTS names belong to them.
"""

from softsoil.files.own_modules import EFFECTS, own_folders

__path__ = [*__path__, *own_folders(EFFECTS)]
